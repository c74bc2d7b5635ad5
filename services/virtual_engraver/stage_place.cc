// What a stage without absolute encoders knows of its place, and what its drives cost it;
// the stage on a real clock.

#include "engrave/core/check.h"
#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {

using link::StageFault;

bool Stage::RefusesWithoutPlace(std::uint32_t run) {
  if (knows_place_) return false;
  run_ = run;  // the host looks for the fault of its run
  Fail(StageFault::kPlaceLost);
  return true;
}

void Stage::StartHoming() {
  if (phase_ != Phase::kRest || fault_ != StageFault::kNone) return;
  knows_place_ = false;
  fault_axes_ = {};
  home_.emplace(*options_.homing, commanded_mm_);
  phase_ = Phase::kJogging;
}

void Stage::AdvanceHome(double seconds) {
  while (home_ && seconds > 0) {
    const JogCourse::Stretch stretch =
        home_->Next(seconds, axes_->IsAtSwitch(home_->axis()));
    FollowCurve(stretch.curve, 0, stretch.seconds);
    seconds -= stretch.seconds;
    if (home_->state() != HomeCourse::State::kUnderWay) EndHomeLeg();
  }
}

void Stage::EndHomeLeg() {
  const int axis = home_->axis();
  if (home_->state() == HomeCourse::State::kAxisFound) {
    const double shift_mm = home_->shift_mm();
    axes_->ShiftPlace(axis, shift_mm);
    commanded_mm_[axis] += shift_mm;
    home_->BeginNextAxis(commanded_mm_);
  }
  const HomeCourse::State state = home_->state();
  if (state == HomeCourse::State::kUnderWay) return;
  home_.reset();
  Rest();
  if (state == HomeCourse::State::kDone) {
    knows_place_ = true;
    StartJog(StartMm(options_), options_.homing->speed_mm_s);
  } else if (state != HomeCourse::State::kHeld) {
    fault_axes_ = {};
    fault_axes_[static_cast<std::size_t>(axis)] = true;
    Fail(state == HomeCourse::State::kStuck ? StageFault::kSwitchStuck
                                            : StageFault::kNoSwitch);
  }
}

void Stage::Rest() {
  commanded_mm_s_ = Vec3::Zero();
  knot_mm_ = commanded_mm_;
  knot_mm_s_ = Vec3::Zero();
  phase_ = Phase::kRest;
}

void Stage::SetDrives(StageFault cause) {
  drives_ = cause;
  if (cause == StageFault::kNone) return;
  if (fault_ != StageFault::kStopPressed) fault_ = cause;
  if (options_.homing) knows_place_ = false;
  passed_ = {};
  if (phase_ == Phase::kRest) return;
  queue_.clear();
  queued_units_ = in_piece_units_ = 0;
  jog_.reset();
  home_.reset();
  commanded_mm_ = actual_mm();
  Rest();
}

// The switches lie outside the travel: at one within it, steps were lost. From Home an
// axis comes out of one.
void Stage::CheckSwitches() {
  if (!options_.homing || !knows_place_) return;
  for (int axis = 0; axis < 3; ++axis) {
    const bool in_travel = actual_mm()[axis] >= options_.travel_min_mm[axis] &&
                           actual_mm()[axis] <= options_.travel_max_mm[axis];
    if (!in_travel || !axes_->IsAtSwitch(axis)) continue;
    knows_place_ = false;
    fault_axes_ = {};
    fault_axes_[static_cast<std::size_t>(axis)] = true;
    return Fail(StageFault::kSwitchMet);
  }
}

void Stage::AdvanceClock(std::uint64_t now_ns) {
  Require(own_clock_.has_value() && now_ns >= now_units_, "the clock goes on alone");
  const double seconds = static_cast<double>(now_ns - now_units_) * unit_s_;
  own_clock_->Show(now_ns);
  AdvanceTo(now_ns);
  if (phase_ == Phase::kJogging) AdvanceJog(seconds);
  CheckSwitches();
  CheckPlace();
}

void Stage::ReceiveTick(std::uint64_t tick, std::uint64_t at_ns, double rate_hz) {
  rate_hz_ = rate_hz;
  LatchAt({tick, at_ns});
}

}  // namespace intaglio::virtual_engraver
