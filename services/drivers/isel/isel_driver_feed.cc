// What the driver of isel's controllers sends, and how its ticks pass (isel_driver.h).

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/drivers/isel/isel_driver.h"

namespace intaglio::drivers {
namespace {

using Outcome = link::TickOutcome;
using namespace std::chrono_literals;

// Steps/s; an axis with little way ends before the others.
constexpr std::int32_t kMinSpeed = 100;
constexpr auto kQuestionPause = 5ms;
constexpr double kHome_s = 300;
// With the lamp on it is the host that is awaited; without one, the plan's time counts.
constexpr auto kStarvedPatience = 1s;

std::chrono::nanoseconds Nanoseconds(double seconds) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

}  // namespace

double IselDriver::WarmRatio() const {
  if (!lamp_on_) return 0;
  const double on_s = std::chrono::duration<double>(now() - lamp_since_).count();
  return warm_up_s_ > 0 ? std::min(1.0, on_s / warm_up_s_) : 1;
}

std::optional<Outcome> IselDriver::WhyDark() const {
  if (stop_ || safe_ || halted_ || chain_open_) return Outcome::kInterlocked;
  if (WarmRatio() < 1) return Outcome::kLampNotReady;
  if (!wanted_open_) return Outcome::kShutterClosed;
  return std::nullopt;
}

bool IselDriver::Fires(std::uint64_t tick) {
  if (!ticks_.fires(tick)) return false;
  const auto why = WhyDark();
  if (why) ticks_.Settle(tick, *why);
  return !why;
}

void IselDriver::Feed() {
  bool more = true;
  while (more && line_.is_idle()) {
    if (homing_ && !home_sent_ && !halted_) {
      home_sent_ = true;
      line_.Send(IselCommand::kHome, kIselHome, kHome_s);
      return;
    }
    if (halted_ || !knows_chain_) {
      more = false;
    } else if (jog_) {
      more = FeedJog();
    } else {
      more = FeedPulse() || FeedRun() || FeedAside();
    }
  }
  if (line_.is_idle()) FeedQuestion();
}

// Where it is, and what holds it, by turns.
void IselDriver::FeedQuestion() {
  if (now() < next_question_) return;
  next_question_ = now() + kQuestionPause;
  asks_chain_ = !asks_chain_;
  if (asks_chain_) {
    line_.Send(IselCommand::kProbe, kIselNoMove);
  } else {
    line_.Send(IselCommand::kPlace, kIselPlace);
  }
}

void IselDriver::SendMove(const IselSteps& to, double seconds,
                          std::optional<Piece> piece) {
  IselSteps speed{};
  double longest_s = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double way = std::abs(static_cast<double>(to[i]) - place_[i]);
    speed[i] =
        std::max(kMinSpeed, static_cast<std::int32_t>(std::min(1e9, way / seconds)));
    longest_s = std::max(longest_s, way / speed[i]);
  }
  planned_end_ = std::max(planned_end_, now()) + Nanoseconds(longest_s);
  move_ = Move{to, PlaceOf(place_), std::move(piece)};
  line_.Send(IselCommand::kMove, IselMove(to, speed), longest_s);
}

bool IselDriver::FeedJog() {
  if (jog_->cancelled || jog_->sent_mm >= jog_->length_mm) return false;
  const double piece_mm = jog_->speed_mm_s * PieceQueue::kMaxPiece_s;
  const double to_mm = std::min(jog_->length_mm, jog_->sent_mm + piece_mm);
  const double seconds = (to_mm - jog_->sent_mm) / jog_->speed_mm_s;
  jog_->sent_mm = to_mm;
  const Vec3 place_mm =
      jog_->from_mm + (jog_->to_mm - jog_->from_mm) * (to_mm / jog_->length_mm);
  const IselSteps to = StepsOf(place_mm);
  if (to != place_) SendMove(to, seconds, std::nullopt);
  return true;
}

// Of a point where the stage is. False: none is there, or it is not decided yet.
bool IselDriver::FeedPulse() {
  if (pulse_tick_ == 0 || is_fired_) return false;
  if (has_lamp() && pulse_tick_ > ticks_.decided_through()) return false;
  if (!Fires(pulse_tick_)) {
    pulse_tick_ = 0;
    return true;
  }
  if (!is_checked_) {
    line_.Send(IselCommand::kCheck, kIselPlace);
  } else {
    is_fired_ = true;
    line_.Send(IselCommand::kPulse, kIselPulse);
  }
  return true;
}

bool IselDriver::FeedRun() {
  if (run_ != Run::kRuns || pulse_tick_ != 0) return false;
  return !pieces_.empty() && FeedPiece();
}

bool IselDriver::FeedPiece() {
  const std::uint64_t decided = has_lamp() ? ticks_.decided_through() : UINT64_MAX;
  if (TickOf(pieces_.front().start_subticks) > decided) return false;
  Piece piece = pieces_.TakeMerged(decided);
  const IselSteps to = StepsOf(piece.to_mm);
  const double seconds = std::max(piece.duration_s, 1e-4);
  if (to == place_) {
    Execute({to, state_.position_mm, std::move(piece)});
  } else {
    SendMove(to, seconds, std::move(piece));
  }
  return true;
}

// A pulse that is asked for while no run moves the stage.
bool IselDriver::FeedAside() {
  if (!has_lamp() || run_ == Run::kRuns || pulse_tick_ != 0) return false;
  const std::uint64_t tick = ticks_.next_fire_after(ticks_.tick());
  const bool before_run = run_ != Run::kWaits || tick < start_tick_;
  if (tick > ticks_.decided_through() || !before_run) return false;
  if (ticks_.gated(tick)) {
    ticks_.Settle(tick, Outcome::kNotInPosition);
    return true;
  }
  // The ticks before it pass first.
  if (ticks_.tick() + 1 < tick) PassTicks();
  pulse_tick_ = tick;
  is_checked_ = false;
  return true;
}

void IselDriver::Execute(const Move& move) {
  if (!move.piece || run_ == Run::kNone) return;
  const Piece& piece = *move.piece;
  executed_through_ = std::max(executed_through_, TickOf(piece.end_subticks));
  // The place before the move was a whole step, too.
  if (!piece.at_ticks_mm.empty()) {
    positions_.push_back({state_.run,
                          TickOf(piece.start_subticks) + 1,
                          PlacesOnChord(move.from_mm, piece),
                          {}});
  }
  if (!piece.pulse || aborted_) return;
  pulse_tick_ = TickOf(piece.end_subticks);
  is_checked_ = false;
}

void IselDriver::EndRun() {
  checks_place_ = run_ == Run::kRuns;
  run_ = Run::kNone;
}

// The controller counts its steps; another place than that of its last move is another
// host, or a reset.
void IselDriver::CheckPlace() {
  if (!std::exchange(checks_place_, false) || state_.fault != intaglio_MOTION_OK) return;
  state_.following_error_max_um = (state_.position_mm - end_mm_).norm() * 1000;
  if (StepsOf(end_mm_) == place_) return;
  SetFault(intaglio_MOTION_FOLLOWING_ERROR,
           "the controller ended elsewhere than the run: check its zero, then resume");
}

// No tick passes before the outcome of a pulse in it is known.
std::uint64_t IselDriver::LimitedByPulse(std::uint64_t tick) const {
  const bool waits = pulse_tick_ != 0 && ticks_.fires(pulse_tick_);
  return waits ? std::min(tick, pulse_tick_ - 1) : tick;
}

// Without a run: through which tick time has come.
std::uint64_t IselDriver::IdleTarget() {
  std::uint64_t target = ticks_.tick();
  if (has_lamp()) {
    target = std::max(target, ticks_.decided_through());
    const std::uint64_t next = ticks_.next_fire_after(ticks_.tick());
    if (!halted_) target = std::min(target, next - 1);
  } else {
    const double passed =
        std::chrono::duration<double>(now() - passed_at_).count() * rate_hz_ +
        passed_part_;
    target += static_cast<std::uint64_t>(passed);
    passed_part_ = passed - static_cast<double>(target - ticks_.tick());
    for (std::uint64_t tick = ticks_.next_fire_after(ticks_.tick()); tick <= target;
         tick = ticks_.next_fire_after(tick)) {
      ticks_.Settle(tick, WhyDark().value_or(Outcome::kLampNotReady));
    }
  }
  return run_ == Run::kWaits ? std::min(target, start_tick_) : target;
}

void IselDriver::PassTicks() {
  const auto pass = [this](std::uint64_t tick) {
    if (tick > ticks_.tick()) ticks_.PassThrough(tick);
  };
  if (run_ != Run::kRuns) {
    pass(LimitedByPulse(IdleTarget()));
    if (run_ == Run::kWaits && ticks_.tick() >= start_tick_ && !halted_ && !is_fired_) {
      run_ = Run::kRuns;
      planned_end_ = now();
    }
  }
  passed_at_ = now();
  if (run_ != Run::kRuns) return;
  std::uint64_t through = LimitedByPulse(executed_through_);
  if (has_lamp()) through = std::min(through, ticks_.decided_through());
  pass(through);
  const bool over =
      pieces_.empty() && pieces_.has_end() && !move_ && pulse_tick_ == 0 && !is_fired_;
  if (over && (aborted_ || !has_lamp() || ticks_.tick() >= executed_through_ ||
               state_.fault != intaglio_MOTION_OK)) {
    end_mm_ = PlaceOf(place_);
    EndRun();
  }
}

void IselDriver::CheckStarved() {
  if (run_ != Run::kRuns || pieces_.has_end() || state_.fault != intaglio_MOTION_OK)
    return;
  if (!pieces_.empty() || pulse_tick_ != 0) {
    planned_end_ = std::max(planned_end_, now());
    return;
  }
  if (now() < planned_end_ + (lamp_on_ ? kStarvedPatience : 0s)) return;
  SetFault(intaglio_MOTION_STARVED,
           "the segments of the run ended before the run: the host was too slow");
}

void IselDriver::Forget() {
  jog_.reset();
  move_.reset();
  homing_ = home_sent_ = false;
  const std::uint64_t last =
      is_fired_ ? std::max(pulse_tick_, ticks_.tick()) : ticks_.tick();
  if (is_fired_) ticks_.Settle(pulse_tick_, Outcome::kNoLongerKnown);
  is_fired_ = is_checked_ = false;
  pulse_tick_ = 0;
  ticks_.UndecideAfter(last);
  if (last > ticks_.tick()) ticks_.PassThrough(last);
  pieces_.Drop();
  run_ = Run::kNone;
  checks_place_ = false;
}

void IselDriver::Halt(intaglio_MotionFault fault, std::string why) {
  if (halted_) return;
  halted_ = safe_ = true;
  leaving_safe_ = false;
  Forget();
  wanted_open_ = false;
  SetFault(fault, std::move(why));
}

void IselDriver::TakeRecovery() {
  if ((!clearing_ && !leaving_safe_) || !line_.up() || chain_open_) return;
  halted_ = false;
  if (std::exchange(leaving_safe_, false)) safe_ = false;
  if (!std::exchange(clearing_, false)) return;
  state_.fault = intaglio_MOTION_OK;
  state_.message.clear();
  ++state_.number;
}

}  // namespace intaglio::drivers
