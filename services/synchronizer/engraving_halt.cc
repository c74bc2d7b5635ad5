#include <fmt/format.h>

#include "services/synchronizer/engraving.h"

// What happens to points that were armed when a run is halted.

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using namespace std::chrono_literals;

// How long a halt waits for the reports of what was armed.
constexpr auto kSettleTimeout = 2s;
// Passes in a row that were broken off over a skipped point before they made any.
constexpr int kMaxFruitlessRuns = 5;

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
    case Missing::kOpenedUnseen:
      return SkipReason::kInterlock;
    default:
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
  Explain(missing, text, fault);
  halted_at_ = now_;
  uncertain_before_halt_ = record_.ledger().count(PointState::kUncertain);
  phase_ = Phase::kHalting;
}

void Engraving::Explain(Missing missing, const std::string& text, bool fault) {
  message_ = text;
  starts_again_ = missing == Missing::kNothing && !fault;
  lost_a_line_ =
      missing == Missing::kLaserLine || missing == Missing::kMotionState ||
      missing == Missing::kSafeState ||
      (missing == Missing::kMotionFault && motion_fault_ != intaglio_MOTION_LIMIT &&
       motion_fault_ != intaglio_MOTION_FOLLOWING_ERROR &&
       motion_fault_ != intaglio_MOTION_WRONG_CONTROLLER);
  if (fault) chain_.Latch(lost_a_line_);
}

// What comes later in the order may lie in the beam of what was passed by, so the run
// starts again there; but not by itself when it was the machine that held a pulse back.
void Engraving::HaltOverSkipped() {
  switch (passed_by_reason_) {
    case SkipReason::kInterlock:
      return Halt(Missing::kDoor,
                  "an interlock of the machine held a pulse back: see to key, door and "
                  "stop, then resume",
                  true);
    case SkipReason::kLamp:
      return Halt(Missing::kLamp, TextOf(Missing::kLamp), true);
    case SkipReason::kShutter:
      return Halt(Missing::kShutter, TextOf(Missing::kShutter), true);
    default:
      break;
  }
  const bool fruitless = record_.fired_point_count() == ended_before_run_;
  fruitless_runs_ = fruitless ? fruitless_runs_ + 1 : 0;
  if (fruitless_runs_ < kMaxFruitlessRuns) {
    return Halt(Missing::kNothing, "pulses were skipped: the run starts again there",
                false);
  }
  fruitless_runs_ = 0;
  Halt(Missing::kNothing,
       "the same point was skipped again and again: see that the stage follows and the "
       "disk keeps up, then resume",
       true);
}

// A dead beam or a blind sensor would go on through the whole block.
void Engraving::HaltOverMissed() {
  Halt(Missing::kNothing,
       fmt::format("no crack was seen of {} pulses in a row: see to lens, block, pulse "
                   "energy and photosensor, then resume",
                   missed_in_a_row_),
       true);
}

// The laser's word on a skipped pulse may come before the stage's word on why, or before
// the controller's own: then the run does not start again by itself.
void Engraving::LookForFaultBehindSkips(const EngravingInputs& inputs) {
  if (!starts_again_) return;
  ChainLinks links = LinksNow(inputs);
  // A run that came too late is no fault of this one.
  if (inputs.motion.run != record_.run()) links.motion_without_fault = true;
  const Missing missing = FirstMissing(links, false);
  if (missing == Missing::kNothing || missing == Missing::kPermission) return;
  Explain(missing,
          missing == Missing::kMotionFault ? inputs.motion.message : TextOf(missing),
          true);
}

// Key, door and stop latch also before and between runs.
void Engraving::TurnChain(const EngravingInputs& inputs) {
  ChainLinks links = LinksNow(inputs);
  // A new arm counts when it can be acted on: a Reset is sent between runs.
  if (phase_ == Phase::kHalting) links.permission_fresh = false;
  const Missing spent_by = chain_.Turn(links, inputs.now);
  if (spent_by == Missing::kNothing || stopping_) return;
  if (phase_ == Phase::kRunning) {
    // An interlock that is open now halts it by itself.
    if (IsUnseen(spent_by)) Halt(spent_by, TextOf(spent_by), true);
    return;
  }
  starts_again_ = lost_a_line_ = false;
  message_ = TextOf(spent_by);
  if (consent_.was_asked()) message_ += "; " + consent_.Question();
}

// A line that leads to another machine is no lost line: somebody changes cables, and is
// to arm when that is done. So each arm is spent while another device answers.
void Engraving::HaltOverOtherDevice(const EngravingInputs& inputs) {
  const std::string why = OtherDevice(inputs, laser_);
  if (stopping_ || why.empty()) return;
  chain_.Latch(false);
  starts_again_ = lost_a_line_ = false;
  if (faulted()) message_ = why + ", then resume";
}

bool Engraving::AskToDisarm() {
  disarm_session_ = laser_.session();
  disarm_seen_ = false;
  disarm_asked_ = laser_.CanSend() && laser_.OpenShutters(0) && laser_.Disarm() &&
                  laser_.RequestStatus();
  return disarm_asked_;
}

// What was decided before it has to be decided anew, also when its answer comes late.
void Engraving::HearDisarmed() {
  if (disarm_seen_ || !disarm_asked_ || disarm_session_ != laser_.session() ||
      !laser_.disarmed()) {
    return;
  }
  decided_ = laser_.status().decided_through;
  disarm_seen_ = true;
}

void Engraving::SettleHalted(const EngravingInputs& inputs) {
  if (halted_at_.count() == 0) halted_at_ = inputs.now;
  const bool late = inputs.now - halted_at_ > kSettleTimeout;
  if (!disarm_asked_ || disarm_session_ != laser_.session()) (void)AskToDisarm();
  const bool disarmed = laser_.up() && disarm_seen_;
  LookForFaultBehindSkips(inputs);
  AbortEarlierRun(inputs);
  if (disarmed) SettleByMemory(late);
  // Who is ending does not wait for a line that may never come back: the intents stay
  // open in the journal, and who takes the job up asks the controller.
  if (late && stopping_) return Finish();
  if (!schedule_.empty() || doubts_left_ > 0) return;
  if (stopping_ ? laser_.up() && !disarmed : !disarmed || !grant_heard_) return;
  if (starts_again_ && inputs.motion.tick < passed_by_tick_ && !late) return;
  const bool moving = inputs.motion.fresh && !inputs.motion.at_rest;
  if (moving && !late) return KeepIdleTicksPassing();
  if (stopping_) return Finish();
  phase_ = Phase::kWaiting;
}

void Engraving::SettleAs(std::vector<PulseResult> points, PointOutcome outcome) {
  for (PulseResult& point : points) {
    point.outcome = outcome;
    point.reason = outcome == PointOutcome::kSkipped ? skip_reason_ : SkipReason::kNone;
  }
  schedule_.Settle(points,
                   [this](const PulseResult& result) { record_.Resolve(result); });
}

}  // namespace intaglio::synchronizer
