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

}  // namespace

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
  Plan(longest_s);
  move_ = Move{to, PlaceOf(place_), std::move(piece)};
  line_.Send(IselCommand::kMove, IselMove(to, speed), longest_s);
}

bool IselDriver::FeedJog() {
  const auto piece = NextJogPiece();
  if (!piece) return false;
  jog_->sent_mm = piece->end_mm;
  const IselSteps to = StepsOf(piece->to_mm);
  if (to != place_) SendMove(to, piece->seconds, std::nullopt);
  return true;
}

// Feeds that of the point where the stage is. False: none is there, or not decided yet.
bool IselDriver::FeedPulse() {
  if (pulse_tick_ == 0 || is_fired_) return false;
  if (pulse_tick_ > DecidedThrough()) return false;
  if (!Fires(pulse_tick_)) {
    pulse_tick_ = 0;
    return true;
  }
  if (!is_checked_) {
    line_.Send(IselCommand::kCheck, kIselPlace);
  } else {
    is_fired_ = true;
    committed_tick_ = pulse_tick_;
    line_.Send(IselCommand::kPulse, kIselPulse);
  }
  return true;
}

bool IselDriver::FeedRun() {
  if (run_ != Run::kRuns || pulse_tick_ != 0) return false;
  return !pieces_.empty() && FeedPiece();
}

bool IselDriver::FeedPiece() {
  const std::uint64_t decided = DecidedThrough();
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
  if (!lamp_on_ || run_ == Run::kRuns || pulse_tick_ != 0) return false;
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

}  // namespace intaglio::drivers
