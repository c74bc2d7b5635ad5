// The lists of points, moves of z, and the outputs, as they are due (point_driver.h).

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/drivers/bjjcz/board_outputs.h"
#include "services/drivers/bjjcz/point_driver.h"

namespace intaglio::drivers {

using Outcome = link::TickOutcome;

void BjjczPointDriver::Feed() {
  if (!broken_.empty() || !line_.is_idle() || !knows_inputs_ || !knows_axis_) return;
  if (stopping_) return;
  if (!jog_) outline_.reset();
  FeedOutputs();
  if (!line_.is_idle()) return;
  if (FeedPlayed() || FeedAxis()) return;
  if (homing_ && !home_sent_ && !halted_) return FeedHome();
  if (halted_) return;
  if (jog_)
    FeedJog();
  else if (run_ == Run::kRuns)
    FeedRun();
  else
    FeedAside();
}

// True: the board has a list.
bool BjjczPointDriver::FeedPlayed() {
  if (!playing_) return false;
  if (!playing_->was_sent() && outline_ && !draws_outline()) {
    playing_.reset();
    lists_.Drop();
    return false;
  }
  if (!playing_->was_sent()) {
    if (!busy_) playing_->Execute(line_);
    return true;
  }
  if (playing_->IsLate(now())) {
    StopController();
    Halt(intaglio_MOTION_SAFE_STATE,
         "the board does not end its list: it is slower than the profile has it to be, "
         "or waits for an input; switch it off and on, check the block, then resume");
    return true;
  }
  if (!playing_->HasEnded(busy_, now())) return true;
  TakeEndOfList();
  return false;
}

void BjjczPointDriver::TakeEndOfList() {
  playing_.reset();
  lists_.SetPlayed();
  const Vec2 at_mm = lists_.at_mm();
  state_.position_mm.head<2>() = at_mm;
  ++state_.number;
  if (outline_) outline_->SetPlayed();
  // By hand: the next run begins here.
  if (jog_) listed_mm_.head<2>() = at_mm;
  for (const Step& step : std::exchange(steps_, {})) Execute(step);
}

void BjjczPointDriver::Execute(const Step& step) {
  if (step.pulse_tick != 0) {
    ticks_.Settle(step.pulse_tick,
                  is_list_uncertain_ ? Outcome::kNoLongerKnown : Outcome::kFiredUnseen);
  }
  if (!step.piece || run_ == Run::kNone) return;
  executed_through_ = std::max(executed_through_, TickOf(step.piece->end_subticks));
  if (step.piece->at_ticks_mm.empty()) return;
  positions_.push_back({state_.run,
                        TickOf(step.piece->start_subticks) + 1,
                        PlacesOnChord(step.from_mm, *step.piece),
                        {}});
}

// True: the axis moves, or settles.
bool BjjczPointDriver::FeedAxis() {
  if (!axis_) return false;
  if (!axis_->was_asked || moving_) return true;
  const auto settle =
      std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * z_settle_s_));
  if (!axis_->rests_at) axis_->rests_at = now();
  if (now() < *axis_->rests_at + settle) return true;
  if (!std::exchange(axis_->asks_place, true)) line_.Send({LmcOperation::kAxisPlace, {}});
  return true;
}

void BjjczPointDriver::MoveAxis(std::int32_t to_steps, double speed_mm_s) {
  const std::uint16_t speed =
      std::max<std::uint16_t>(1, ToUint16(std::floor(speed_mm_s * steps_per_mm_)));
  const std::uint32_t number = AxisNumber(to_steps);
  axis_ = AxisMove{.to_steps = to_steps};
  axis_to_steps_ = to_steps;
  line_.Send({LmcOperation::kAxisSpeed, {speed, speed}});
  line_.Send({LmcOperation::kAxisRamp, {ToUint16(1000 * z_ramp_s_)}});
  line_.Send({LmcOperation::kAxisTo,
              {static_cast<std::uint16_t>(number & 0xFFFF),
               static_cast<std::uint16_t>(number >> 16)}});
}

// Before the origin is found the axis is nowhere.
void BjjczPointDriver::FeedHome() {
  home_sent_ = true;
  state_.homed = false;
  axis_ = AxisMove{.is_to_origin = true};
  line_.Send({LmcOperation::kAxisOrigin, {}});
}

void BjjczPointDriver::FeedJog() {
  if (outline_) return FeedOutline();
  const auto piece = NextJogPiece();
  if (!piece) return;
  const Vec3 to_mm = pieces_.Snapped(piece->to_mm);
  const double across_mm = (to_mm - state_.position_mm).head<2>().norm();
  if (across_mm > 0) {
    lists_.AddSlow(to_mm.head<2>(), std::max(1e-3, across_mm / jog_->speed_mm_s));
    Play();
    return;  // z, if it moves, too, comes behind
  }
  jog_->sent_mm = piece->end_mm;
  const std::int32_t steps = StepsOf(to_mm.z());
  if (steps != axis_steps_) MoveAxis(steps, std::min(z_mm_s_, jog_->speed_mm_s));
}

void BjjczPointDriver::FeedRun() {
  for (;;) {
    if (!held_) {
      if (pieces_.empty() || TickOf(pieces_.front().start_subticks) > DecidedThrough())
        break;
      held_ = pieces_.TakeMerged(DecidedThrough());
    }
    if (!AddPiece(*held_)) break;
    held_.reset();
  }
  if (!lists_.empty()) return Play();
  // Pieces that moved nothing.
  for (const Step& step : std::exchange(steps_, {})) Execute(step);
  if (!held_) return;
  const std::int32_t steps = StepsOf(held_->to_mm.z());
  if (steps != axis_steps_) MoveAxis(steps, z_mm_s_);
}

bool BjjczPointDriver::AddPiece(const Piece& piece) {
  if (StepsOf(piece.to_mm.z()) != axis_steps_) return false;
  const std::uint64_t tick = TickOf(piece.end_subticks);
  if (piece.pulse && tick > DecidedThrough()) return false;
  const bool fires = piece.pulse && !aborted_ && Fires(tick);
  const bool moves = (pieces_.Snapped(piece.to_mm) - listed_mm_).head<2>().norm() > 0;
  const double power_ratio = fires ? powers_.At(tick) : 1;
  if ((fires || moves) &&
      !lists_.Add(piece.to_mm.head<2>(), fires, power_ratio, PulsesAt(tick)))
    return false;
  steps_.push_back({piece, listed_mm_, fires ? tick : 0});
  listed_mm_ = pieces_.Snapped(piece.to_mm);
  if (fires) committed_tick_ = tick;
  return true;
}

// A pulse that is asked for while no run moves the head.
void BjjczPointDriver::FeedAside() {
  if (!lamp_on_) return;
  const std::uint64_t tick = ticks_.next_fire_after(ticks_.tick());
  const bool before_run = run_ != Run::kWaits || tick < start_tick_;
  if (tick > ticks_.decided_through() || !before_run) return;
  if (ticks_.gated(tick)) return ticks_.Settle(tick, Outcome::kNotInPosition);
  if (ticks_.tick() + 1 < tick) PassTicks();
  if (!Fires(tick)) return;
  if (!lists_.Add(state_.position_mm.head<2>(), true, powers_.At(tick), PulsesAt(tick)))
    return Play();  // the board rests first
  steps_.push_back({std::nullopt, state_.position_mm, tick});
  committed_tick_ = tick;
  Play();
}

void BjjczPointDriver::Play() {
  const LmcList list = lists_.Take();
  double planned_s = 0;
  for (const Step& step : steps_) planned_s += step.piece ? step.piece->duration_s : 0;
  Plan(std::max(planned_s, list.seconds));
  if (board_.laser() == BJJCZ_LASER_FIBRE && !std::exchange(oscillates_, true))
    line_.Send({LmcOperation::kFibreOscillator, {1}});
  Send(list);
}

void BjjczPointDriver::Send(const LmcList& list) {
  SendList(list, line_);
  is_list_uncertain_ = false;
  playing_.emplace(list.seconds);
}

std::uint16_t BjjczPointDriver::WantedOutputs() const {
  return OutputBits(board_,
                    {
                        .permitted = wanted_open_ && closed_ && !halted_ && !homing_,
                        .runs = run_ != Run::kNone,
                        .in_outline = outline_ && jog_,
                        .shows = draws_outline() && outline_->is_there() && closed_,
                    });
}

void BjjczPointDriver::FeedOutputs() {
  const std::uint16_t wanted = WantedOutputs();
  if (asked_outputs_ == wanted) return;
  // Which points of the list were before it, nobody knows.
  const bool closes_gate = (wanted >> board_.gate_output() & 1) == 0;
  if (playing_ && closes_gate) is_list_uncertain_ = true;
  asked_outputs_ = wanted;
  line_.Send({LmcOperation::kWritePort, {wanted}});
}

}  // namespace intaglio::drivers
