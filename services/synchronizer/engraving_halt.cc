#include "services/synchronizer/engraving.h"

// What happens to points that were armed when a run is halted.

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using namespace std::chrono_literals;

// How long a halt waits for the reports of what was armed.
constexpr auto kSettleTimeout = 2s;

SkipReason ReasonOf(Missing missing) {
  switch (missing) {
    case Missing::kPermission:
      return SkipReason::kNoPermission;
    case Missing::kLaserLine:
      return SkipReason::kLink;
    case Missing::kLamp:
      return SkipReason::kLamp;
    case Missing::kShutter:
      return SkipReason::kShutter;
    case Missing::kMotionState:
    case Missing::kMotionFault:
      return SkipReason::kPosition;
    case Missing::kEmergencyStop:
    case Missing::kKey:
    case Missing::kDoor:
    case Missing::kSafeState:
      return SkipReason::kInterlock;
    case Missing::kNothing:
      break;
  }
  return SkipReason::kNoPermission;
}

}  // namespace

void Engraving::Halt(Missing missing, const std::string& text, bool fault) {
  // A full window of the line is no reason to wait: the next turns ask again.
  (void)AskToDisarm();
  (void)feed_.Abort();
  schedule_.DropUnarmed();
  windows_.clear();
  skip_reason_ = ReasonOf(missing);
  // What was never sent can never fire.
  SettleAs(schedule_.ArmedWithin(sent_through_ + 1, UINT64_MAX), PointOutcome::kSkipped);
  message_ = text;
  needs_new_grant_ = fault;
  starts_again_ = missing == Missing::kNothing && !fault;
  lost_a_line_ =
      missing == Missing::kLaserLine || missing == Missing::kMotionState ||
      missing == Missing::kSafeState ||
      (missing == Missing::kMotionFault && motion_fault_ != intaglio_MOTION_LIMIT &&
       motion_fault_ != intaglio_MOTION_FOLLOWING_ERROR);
  halted_at_ = now_;
  phase_ = Phase::kHalting;
}

bool Engraving::AskToDisarm() {
  disarm_session_ = laser_.session();
  disarm_asked_ = laser_.CanSend() && laser_.OpenShutters(0) && laser_.Disarm() &&
                  laser_.RequestStatus();
  return disarm_asked_;
}

void Engraving::SettleHalted(const EngravingInputs& inputs) {
  const bool late = inputs.now - halted_at_ > kSettleTimeout;
  if (!disarm_asked_ || disarm_session_ != laser_.session()) (void)AskToDisarm();
  if (laser_.disarmed() && disarm_asked_) {
    if (laser_.session() != session_) {
      SettleByCounter();
    } else {
      SettleAs(schedule_.ArmedWithin(laser_.status().decided_through + 1, UINT64_MAX),
               PointOutcome::kSkipped);
      // The rest was reported before that status; what is not is lost for good.
      if (late) SettleAs(schedule_.ArmedWithin(0, UINT64_MAX), PointOutcome::kUncertain);
    }
  }
  // Who is ending does not wait for a line that may never come back.
  if (late && stopping_) {
    SettleAs(schedule_.ArmedWithin(0, UINT64_MAX), PointOutcome::kUncertain);
  }
  if (!schedule_.empty()) return;
  const bool moving = inputs.motion.fresh && !inputs.motion.at_rest;
  if (moving && !late) return;
  if (stopping_) return Finish();
  FinishRun();
}

// A lost line took the reports with it. The controller's counters are the truth: ticks
// after the last one fired did not fire; the others all did if the count says so.
void Engraving::SettleByCounter() {
  const link::LaserStatus& status = laser_.status();
  const auto open = schedule_.ArmedWithin(0, UINT64_MAX);
  if (open.empty()) return;
  if (laser_.identity().power_up != power_up_) {
    return SettleAs(open, PointOutcome::kUncertain);
  }
  SettleAs(schedule_.ArmedWithin(status.last_fired_tick + 1, UINT64_MAX),
           PointOutcome::kSkipped);
  const auto candidates = schedule_.ArmedWithin(0, status.last_fired_tick);
  const std::uint64_t fired = status.pulse_count - pulses_before_job_ - fired_count_;
  if (fired == 0) return SettleAs(candidates, PointOutcome::kSkipped);
  if (fired != candidates.size()) return SettleAs(candidates, PointOutcome::kUncertain);
  settled_by_counter_ += fired;
  SettleAs(candidates, PointOutcome::kMade);
}

void Engraving::SettleAs(std::vector<PulseResult> points, PointOutcome outcome) {
  for (PulseResult& point : points) {
    point.outcome = outcome;
    point.reason = outcome == PointOutcome::kSkipped ? skip_reason_ : SkipReason::kNone;
  }
  schedule_.Settle(points, [this](const PulseResult& result) { Record(result); });
}

}  // namespace intaglio::synchronizer
