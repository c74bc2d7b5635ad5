// What the driver of the grbl family sends, and how its ticks pass (grbl_driver.h).

#include <algorithm>
#include <utility>

#include "services/drivers/grbl/grbl_driver.h"

namespace intaglio::drivers {
namespace {

using Outcome = link::TickOutcome;

// A step aside and back takes this time.
constexpr double kAside_s = 0.012;
constexpr char kBarrier[] = "G4P0";
constexpr char kJogCancel = static_cast<char>(0x85);

}  // namespace

double GrblDriver::AheadSeconds() const {
  double ahead_s = 0;
  for (const InFlight& one : in_flight_) ahead_s += one.move.planned_s;
  return ahead_s;
}

bool GrblDriver::MaySendPulses() const {
  return unsettled_.size() < kMaxUnsettled && AheadSeconds() < kAhead_s;
}

bool GrblDriver::BarrierIsDue() const {
  const auto newer = std::count_if(unsettled_.begin(), unsettled_.end(),
                                   [this](auto tick) { return tick > barrier_tick_; });
  return newer >= static_cast<std::ptrdiff_t>(kPointsPerBarrier);
}

void GrblDriver::Feed() {
  if (halted_) return;
  if (homing_) return FeedHome();
  if (!line_.takes_lines()) return;
  if (jog_) return FeedJog();
  if (zero_) return FeedZero();
  FeedEnable();
  bool more = true;
  while (more) {
    if (pending_ && !SendPending()) return;
    if (BarrierIsDue()) FeedBarrier();
    if (run_ == Run::kRuns) {
      more = FeedProgram();
    } else {
      more = FeedAsides(ticks_.decided_through());
    }
  }
}

bool GrblDriver::SendDark() {
  if (is_dark_) return true;
  is_dark_ = line_.Send({"M5S0"});
  if (!is_dark_) return false;
  commanded_open_ = false;
  in_flight_.push_back({InFlight::What::kDisable});
  return true;
}

// A controller that is locked is dark since its reset, and takes $H alone.
void GrblDriver::FeedHome() {
  if (home_sent_ || (!line_.locked() && !SendDark()) || !in_flight_.empty()) return;
  home_sent_ = line_.SendHome();
  if (home_sent_) state_.homed = false;
}

void GrblDriver::FeedZero() {
  if (!SendDark() || !in_flight_.empty()) return;
  if (line_.Send({ZeroLine(zero_->here_mm, zero_->sets)}))
    in_flight_.push_back({InFlight::What::kZero});
}

void GrblDriver::FeedJog() {
  if (!SendDark()) return;
  if (jog_->cancelled) {
    // A line may be parsed behind the first one; so it is repeated while one moves.
    const bool moves = grbl_.state == GrblState::kJog || !in_flight_.empty();
    if (moves && !line_.has_unsent()) line_.SendRealtime(kJogCancel);
    return;
  }
  while (jog_moves_.may_send() && AheadSeconds() < kAhead_s) {
    const auto piece = NextJogPiece();
    if (!piece) return;
    const auto line = jog_moves_.Line(piece->to_mm, jog_->speed_mm_s);
    if (line && !line_.Send({*line})) return;
    jog_->sent_mm = piece->end_mm;
    if (!line) continue;
    jog_moves_.TakeSent(piece->to_mm);
    GrblMove move;
    move.to_mm = piece->to_mm;
    move.planned_s = piece->seconds;
    in_flight_.push_back({InFlight::What::kMove, std::move(move)});
    UpdateReach();
  }
}

void GrblDriver::UpdateReach() {
  Box3 reach{state_.position_mm, state_.position_mm};
  for (const InFlight& one : in_flight_) {
    if (one.what != InFlight::What::kMove) continue;
    reach.min_mm = reach.min_mm.cwiseMin(one.move.to_mm);
    reach.max_mm = reach.max_mm.cwiseMax(one.move.to_mm);
  }
  line_.SetReach(reach);
}

// False: nothing more can be sent now.
bool GrblDriver::FeedProgram() {
  if (unsettled_.size() >= kMaxUnsettled) {
    FeedBarrier();
    return false;
  }
  if (AheadSeconds() >= kAhead_s) {
    // Without Bf in the status only a barrier shows what has been executed.
    if (grbl_.free_blocks < 0) FeedBarrier();
    return false;
  }
  pending_ =
      program_.Next(DecidedThrough(), [this](std::uint64_t tick) { return Fires(tick); });
  if (!pending_) FeedBarrier();
  return pending_.has_value();
}

// Pulses that are asked for while no run moves the stage.
bool GrblDriver::FeedAsides(std::uint64_t through) {
  if (!lamp_on_) return false;
  const std::uint64_t tick = ticks_.next_fire_after(
      unsettled_.empty() ? ticks_.tick() : std::max(ticks_.tick(), unsettled_.back()));
  const bool before_run = run_ != Run::kWaits || tick < start_tick_;
  if (tick > through || !before_run) {
    if (!unsettled_.empty()) FeedBarrier();
    return false;
  }
  if (ticks_.gated(tick)) {
    ticks_.Settle(tick, Outcome::kNotInPosition);
    return true;
  }
  if (!Fires(tick)) return true;
  if (!MaySendPulses()) {
    FeedBarrier();
    return false;
  }
  program_.RestAt(state_.position_mm);
  pending_ = program_.Aside(tick);
  pending_->moves.back().planned_s = kAside_s;
  return true;
}

void GrblDriver::FeedBarrier() {
  if (in_flight_.empty() && unsettled_.empty()) return;
  if (!in_flight_.empty() && in_flight_.back().what != InFlight::What::kMove) return;
  if (!line_.Send({kBarrier})) return;
  InFlight barrier{InFlight::What::kBarrier};
  barrier.settles = barrier_tick_ =
      unsettled_.empty() ? barrier_tick_ : unsettled_.back();
  in_flight_.push_back(barrier);
}

void GrblDriver::FeedEnable() {
  if (wanted_open_ == commanded_open_) return;
  if (!line_.Send({wanted_open_ ? "M4S0" : "M5S0"})) return;
  commanded_open_ = wanted_open_;
  in_flight_.push_back(
      {wanted_open_ ? InFlight::What::kEnable : InFlight::What::kDisable});
}

// Of the moves that were sent; what does not move displaces none behind it.
bool GrblDriver::IsPlaceCertain() const {
  return std::ranges::all_of(in_flight_, [](const InFlight& one) {
    return one.acknowledged || one.what != InFlight::What::kMove || !one.move.has_line;
  });
}

// A lit write waits until the place is certain, and meanwhile its pulse may be taken
// back: it is judged once more when it leaves.
bool GrblDriver::SendPending() {
  if (pending_->lights() && !Fires(pending_->knot_tick)) pending_->Darken();
  if (pending_->lights() && !IsPlaceCertain()) return false;
  if (!pending_->lines.empty() && !line_.Send(pending_->lines)) return false;
  for (GrblMove& move : pending_->moves) {
    if (move.pulse_tick != 0) {
      unsettled_.push_back(move.pulse_tick);
      committed_tick_ = std::max(committed_tick_, move.pulse_tick);
    }
    Plan(move.planned_s);
    in_flight_.push_back({InFlight::What::kMove, std::move(move)});
  }
  pending_.reset();
  Executed(0);
  UpdateReach();
  return true;
}

void GrblDriver::TakeOk() {
  for (std::size_t i = 0; i < in_flight_.size(); ++i) {
    InFlight& one = in_flight_[i];
    const bool is_move = one.what == InFlight::What::kMove;
    if (one.acknowledged || (is_move && !one.move.has_line)) continue;
    one.acknowledged = true;
    // All others wait for an empty planner.
    if (!is_move) ExecuteThrough(i);
    return;
  }
}

void GrblDriver::ExecuteThrough(std::size_t index) {
  const InFlight last = in_flight_[index];
  for (std::size_t i = 0; i <= index; ++i) {
    const InFlight one = std::move(in_flight_.front());
    in_flight_.pop_front();
    if (one.what == InFlight::What::kMove) Execute(one.move);
  }
  if (last.what == InFlight::What::kEnable) open_ = true;
  if (last.what == InFlight::What::kDisable) open_ = false;
  if (last.what == InFlight::What::kZero && zero_) {
    line_.TakeZero(zero_->sets);
    zero_.reset();
  }
  while (!unsettled_.empty() && unsettled_.front() <= last.settles) {
    ticks_.Settle(unsettled_.front(), Outcome::kFiredUnseen);
    unsettled_.pop_front();
  }
  if (in_flight_.empty()) quiet_at_ = now();
}

// So many of the first acknowledged lines have left the planner.
void GrblDriver::Executed(std::size_t lines) {
  while (!in_flight_.empty() && in_flight_.front().what == InFlight::What::kMove) {
    const InFlight& front = in_flight_.front();
    if (front.move.has_line && (lines == 0 || !front.acknowledged)) return;
    if (front.move.has_line) --lines;
    Execute(front.move);
    in_flight_.pop_front();
    if (in_flight_.empty()) quiet_at_ = now();
  }
}

void GrblDriver::Execute(const GrblMove& move) {
  if (move.through_tick == 0 || run_ == Run::kNone) return;
  executed_through_ = std::max(executed_through_, move.through_tick);
  if (move.places_mm.empty()) return;
  positions_.push_back({state_.run, move.first_tick, move.places_mm, {}});
}

// No tick passes before the outcome of a pulse in it is known.
std::uint64_t GrblDriver::LimitedByPulses(std::uint64_t tick) const {
  if (!unsettled_.empty()) tick = std::min(tick, unsettled_.front() - 1);
  for (const std::uint64_t knot :
       {pending_ ? pending_->knot_tick : 0, program_.pulse_tick()}) {
    if (knot != 0 && ticks_.fires(knot)) tick = std::min(tick, knot - 1);
  }
  return tick;
}

std::uint64_t GrblDriver::ForgetSent() {
  pending_.reset();
  const std::uint64_t last = unsettled_.empty() ? 0 : unsettled_.back();
  for (const std::uint64_t tick : unsettled_) {
    ticks_.Settle(tick, Outcome::kNoLongerKnown);
  }
  unsettled_.clear();
  in_flight_.clear();
  zero_.reset();
  program_.ForgetModes();
  commanded_open_ = open_ = false;
  return last;
}

void GrblDriver::Recover() { (void)line_.Recover(grbl_); }

}  // namespace intaglio::drivers
