#include "services/synchronizer/engraving.h"

#include <utility>

#include "services/job/machine/position_tolerance.h"

namespace intaglio::synchronizer {
namespace {

// In lockstep a run begins after all decided ticks: these have to have passed, and the
// stamps of all but so many ticks have to have come.
constexpr std::uint64_t kMaxUnstampedTicks = 16;

SkipReason ReasonOf(Missing missing) {
  switch (missing) {
    case Missing::kLaserLine:
      return SkipReason::kLink;
    case Missing::kLampSync:
    case Missing::kLamp:
      return SkipReason::kLamp;
    case Missing::kShutter:
      return SkipReason::kShutter;
    case Missing::kMotionState:
    case Missing::kMotionFault:
    case Missing::kBlockPlace:
      return SkipReason::kPosition;
    case Missing::kEmergencyStop:
    case Missing::kChain:
    case Missing::kKey:
    case Missing::kDoor:
    case Missing::kDoorLock:
    case Missing::kInput:
    case Missing::kSafeState:
    case Missing::kOpenedUnseen:
      return SkipReason::kInterlock;
    default:
      break;
  }
  return SkipReason::kNoPermission;
}

}  // namespace

Engraving::Engraving(EngravingJob job, drivers::LaserController& laser, MotionFeed& feed,
                     JournalWriter& journal, PermissionChain& chain,
                     PulseSchedule::ResultSink results)
    : WorkStates(chain, consent_),
      job_(std::move(job)),
      laser_(laser),
      results_(std::move(results)),
      record_(job_.machine_points_mm.size(), job_.photosensor_feedback, journal,
              [this](const PulseResult& result) { Note(result); }),
      ticks_(laser, record_),
      horizon_(laser, job_.plan.rate_hz),
      preparation_(job_, laser),
      shutters_(laser),
      run_(job_, feed, horizon_, ticks_, record_, shutters_),
      settling_(laser, feed, ticks_, record_),
      consent_(job_, record_, chain),
      progress_(job_.plan.rate_hz) {
  ticks_.SetPulsesPerPoint(job_.pulses_per_point);
  if (job_.earlier.points.empty()) return;
  taken_up_ = true;
  phase_ = Phase::kHalting;
  message_ =
      "the job continues: requesting the outcomes of the armed ticks from the laser "
      "controller";
  settling_.BeginTakenUp(job_.earlier);
  consent_.TakeUp();
}

Engraving::Activity Engraving::activity() const {
  switch (phase_) {
    case Phase::kPreparing:
    case Phase::kWaiting:
      return Activity::kIdle;
    case Phase::kRunning:
      return Activity::kRuns;
    case Phase::kHalting:
      return Activity::kSettles;
    case Phase::kDone:
      break;
  }
  return Activity::kDone;
}

std::string Engraving::TextFor(Missing missing) const {
  const std::string& open_input = laser_.accessories().open_input;
  if (missing == Missing::kInput && !open_input.empty())
    return open_input + ", then resume";
  const bool of_stage =
      missing == Missing::kMotionFault || missing == Missing::kOpenedUnseen;
  return of_stage && !motion_message_.empty() ? motion_message_ : TextOf(missing);
}

void Engraving::Note(const PulseResult& result) {
  if (result.reason != SkipReason::kLeftOut) run_.Note(result);
  disturbances_.Add(result);
  consent_.Note(result);
  results_(result);
}

ChainLinks Engraving::LinksNow(const EngravingInputs& inputs) const {
  ChainLinks links = LinksOf(inputs, inputs.motion, laser_, shutters_.run_mask());
  links.block_at_place =
      !job_.block_stage_mm ||
      inputs.motion.HasBlockAt(*job_.block_stage_mm, job_.position_tolerance_um / 1e3);
  links.door_locked = !job_.needs_door_lock || laser_.Has(link::kDoorLocked);
  return links;
}

void Engraving::Turn(const EngravingInputs& inputs) {
  granted_ = inputs.permission_granted;
  motion_message_ = inputs.motion.message;
  horizon_.Observe(inputs.now);
  settling_.TakeDisarmed();
  run_.PlacePulses(inputs);
  const Missing unseen = TurnChain(LinksNow(inputs), inputs.now);
  if (unseen != Missing::kNothing) Halt({unseen, TextFor(unseen), true}, inputs);
  const std::string other_device = OtherDevice(inputs.motion, laser_);
  RefuseArms(other_device.empty() ? inputs.zero_refusal : other_device);
  ReceiveConsent(inputs);
  AskOverUncertain(inputs);
  WatchProgress(inputs);
  // While it runs every window flushes; afterwards the last outcomes would wait for long.
  if (phase_ != Phase::kRunning) record_.FlushAppended();
  if (!inputs.block_failure.empty() && activity() == Activity::kIdle)
    Halt({Missing::kBlockPlace, inputs.block_failure, true}, inputs);
  switch (phase_) {
    case Phase::kPreparing:
      return Prepare(inputs);
    case Phase::kWaiting:
      return Wait(inputs);
    case Phase::kRunning:
      return Run(inputs);
    case Phase::kHalting:
      return Settle(inputs);
    case Phase::kDone:
      return;
  }
}

// Armed, warm, and waiting for no person; a line that comes back by itself counts.
bool Engraving::works(const EngravingInputs& inputs) const {
  const bool armed = inputs.permission_granted && inputs.permission_fresh;
  const bool repairs_itself = lost_a_line_ && started();
  const bool lamp_is_warm = !laser_.up() || laser_.Has(link::kLampWarm);
  return !stopping_ && !asks() && job_.block_misfit.empty() && lamp_is_warm &&
         (faulted() ? repairs_itself : armed) && !record_.ledger().all_ended();
}

void Engraving::WatchProgress(const EngravingInputs& inputs) {
  const bool motion_up = inputs.motion.fresh && !inputs.motion.line_down();
  if (laser_was_up_ && !laser_.up()) ++disturbances_.line_loss_count;
  if (motion_was_up_ && !motion_up) ++disturbances_.line_loss_count;
  laser_was_up_ = laser_.up();
  motion_was_up_ = motion_up;
  disturbances_.run_count = run_.count();
  const PointLedger& ledger = record_.ledger();
  progress_.Update({.tick = laser_.up() ? laser_.status().tick : 0,
                    .works = works(inputs),
                    .speed_percent = inputs.speed_percent,
                    .made_count = ledger.count(PointState::kMade),
                    .ended_count = ledger.size() - ledger.count(PointState::kPlanned) -
                                   ledger.count(PointState::kSkipped) -
                                   ledger.count(PointState::kArmed),
                    .left_out_count = ledger.count(PointState::kLeftOut),
                    .disturbances = disturbances_});
  alarm_ = progress_.stall()
               ? TextOf(*progress_.stall(),
                        ToleranceMismatch(inputs.motion.position_tolerance_um,
                                          job_.position_tolerance_um))
               : "";
}

void Engraving::Prepare(const EngravingInputs& inputs) {
  if (stopping_) return Finish();
  std::string wait = preparation_.Refusal();
  if (wait.empty()) {
    const ChainLinks links = LinksNow(inputs);
    const bool granted = chain_.has_grant(links);
    if (granted) (void)preparation_.LightLamp(inputs.now);
    preparation_.LeaveSafeState(chain_.may_reset(links), inputs.now);
    const bool lit = granted || laser_.Has(link::kLampOn);
    if (preparation_.NeedsTicks(inputs.motion, lit)) SendIdleTicks();
    wait = preparation_.WhatIsMissing(inputs.motion, lit);
    if (!lit && wait.empty()) wait = TextOf(Missing::kPermission);
  }
  // A fault that waits for the operator keeps its message.
  if (!faulted()) message_ = wait;
  if (wait.empty()) phase_ = Phase::kWaiting;
}

void Engraving::Wait(const EngravingInputs& inputs) {
  const auto nothing_is_left = [&] {
    return !consent_.KeepsJobOpen(inputs) &&
           (!record_.ledger().NextOpen(0) || run_.is_fruitless());
  };
  if (stopping_ || nothing_is_left()) return Finish();
  if (preparation_.is_lost()) {
    phase_ = Phase::kPreparing;
    return;
  }
  const ChainLinks links = LinksNow(inputs);
  const bool has_lamp = !chain_.has_grant(links) || preparation_.LightLamp(inputs.now);
  preparation_.LeaveSafeState(chain_.may_reset(links), inputs.now);
  // In lockstep it brakes only while ticks pass, which in a safe state none does.
  const bool seen = inputs.motion.fresh && !inputs.motion.line_down();
  if (seen && !inputs.motion.at_rest) {
    if (run_count() == 0 && !inputs.stage_approaches)
      settling_.AbortEarlierRun(inputs.motion, inputs.now);
    SendIdleTicks();
  }
  const bool closed = shutters_.KeepClosed(inputs.now);
  if (!MayFire(inputs) || !ClocksAreKnown(inputs) || !has_lamp) return;
  if (shutters_.fails_to_close(inputs.now)) {
    message_ = "a shutter does not close: check its drive, then the job continues";
  }
  if (inputs.stage_approaches) message_ = "the stage is driven to where the job begins";
  // The plan begins where the stage is, and with a shutter that is seen to open.
  if (!closed || !inputs.motion.at_rest || inputs.stage_approaches) return;
  bool reopened_any = false;
  const bool all_open =
      record_.LeaveOutBefore(inputs.first_point) && consent_.Reopen(inputs, reopened_any);
  if (reopened_any) run_.ForgetFruitless();
  if (all_open && JournalIsWritten()) BeginRun(inputs);
}

// All links but the shutters, which open when the others hold.
bool Engraving::MayFire(const EngravingInputs& inputs) {
  ChainLinks links = LinksNow(inputs);
  if (!chain_.latched() && inputs.motion.is_cleared_by_a_run())
    links.motion_without_fault = true;
  const Missing missing = chain_.WhatIsMissing(links, false);
  if (missing == Missing::kNothing) return true;
  // Only a person finds the place again, by motion that no armed job allows.
  const bool place_is_lost = missing == Missing::kMotionFault &&
                             inputs.motion.fault == intaglio_MOTION_PLACE_LOST;
  if (place_is_lost && chain_.has_grant(links)) {
    Halt({missing, TextFor(missing), true}, inputs);
    return false;
  }
  starts_again_ = false;
  if (!faulted()) {
    message_ = missing == Missing::kBlockPlace && inputs.stage_approaches
                   ? "the stage moves the block to the job's place"
                   : TextFor(missing);
  }
  return false;
}

// How far ahead to plan is not known before the lamp's pace is, and a stage on a clock of
// its own is moved only by a clock that is known.
bool Engraving::ClocksAreKnown(const EngravingInputs& inputs) {
  if (!horizon_.is_settled()) return false;
  horizon_.UseMotionClock(inputs.motion_clock);
  if (inputs.motion_clock == nullptr) return true;
  if (inputs.motion_clock->settled()) {
    return !horizon_.lockstep() ||
           inputs.motion_clock->newest_tick() + kMaxUnstampedTicks >= ticks_.decided();
  }
  if (!started()) message_ = "the clock of the stage's controller is being measured";
  SendIdleTicks();
  return false;
}

// With room for what a run appends, and nothing that only this process knows.
bool Engraving::JournalIsWritten() {
  if (record_.is_durable()) return true;
  if (record_.disk_failed()) message_ = record_.disk_error();
  return false;
}

void Engraving::BeginRun(const EngravingInputs& inputs) {
  if (!shutters_.Open(run_.NextMask(), inputs.now)) return;
  if (!started() || record_.power_up() != laser_.identity().power_up ||
      record_.leaves_out_pulses()) {
    record_.TakeCounters(laser_);
  }
  record_.AcceptOpenings(laser_, chain_.counters().openings);
  consent_.BeginRun();
  run_.Begin(inputs);
  message_.clear();
  phase_ = Phase::kRunning;
}

void Engraving::Run(const EngravingInputs& inputs) {
  if (stopping_) return Halt({Missing::kNothing, message_, false}, inputs);
  if (ticks_.session_lost()) {
    return Halt({Missing::kLaserLine, TextOf(Missing::kLaserLine), true}, inputs);
  }
  ChainLinks links = LinksNow(inputs);
  // Until the controller executes this run, a fault is that of an older one, which the
  // bridge clears, or a start that came too late, which is tried again.
  if (!run_.is_executed(inputs.motion) && inputs.motion.is_cleared_by_a_run())
    links.motion_without_fault = true;
  const bool with_shutters = shutters_.UpdateSeenOpen();
  if (laser_.simulates_time() && IsOnlyLate(links, with_shutters)) {
    message_ = links.permission_fresh ? kLateState : kLatePermission;
    waits_for_late_ = true;
    return;
  }
  if (std::exchange(waits_for_late_, false)) message_.clear();
  const Missing missing = chain_.WhatIsMissing(links, with_shutters);
  if (missing != Missing::kNothing) {
    const bool fault = missing != Missing::kPermission;
    return Halt({missing, TextFor(missing), fault}, inputs);
  }
  if (const auto reason = run_.Turn(inputs)) return Halt(*reason, inputs);
  if (!run_.is_finished(inputs)) return;
  run_.Finish();
  phase_ = Phase::kWaiting;
}

void Engraving::Halt(const HaltReason& reason, const EngravingInputs& inputs) {
  settling_.Begin(ReasonOf(reason.missing), inputs.now);
  Explain(reason, inputs.motion.fault);
  phase_ = Phase::kHalting;
}

void Engraving::Explain(const HaltReason& reason, intaglio_MotionFault motion_fault) {
  const bool lost = cell::IsLostLine(reason.missing, IsLateMotion(motion_fault));
  WorkStates::Explain(reason.missing, reason.text, lost, reason.fault,
                      reason.starts_again());
}

void Engraving::Settle(const EngravingInputs& inputs) {
  CheckFaultBehindSkips(inputs);
  if (run_count() == 0) settling_.AbortEarlierRun(inputs.motion, inputs.now);
  const auto finding =
      settling_.Turn(inputs.now, inputs.grant.number > 0, run_count() == 0);
  if (finding) Explain({Missing::kNothing, *finding, true}, inputs.motion.fault);
  LeaveHalt(inputs);
}

void Engraving::LeaveHalt(const EngravingInputs& inputs) {
  const bool late = settling_.is_late(inputs.now), disarmed = settling_.disarmed();
  // A process that is ending does not wait for a line that may never come back: the
  // intents stay open in the journal, and the synchronizer that takes the job up asks the
  // controller.
  if (late && stopping_) return Finish();
  if (!settling_.all_settled()) return;
  const bool grant_known = inputs.grant.number > 0;
  if (stopping_ ? laser_.up() && !disarmed : !disarmed || !grant_known) return;
  if (starts_again_ && inputs.motion.tick < run_.passed_by_tick() && !late) return;
  const bool moving = inputs.motion.fresh && !inputs.motion.at_rest;
  if (moving && !late) return SendIdleTicks();
  if (stopping_) return Finish();
  phase_ = Phase::kWaiting;
}

// The laser's report of a skipped pulse may come before the stage's report of why, or
// before the controller's own: then the run does not start again by itself.
void Engraving::CheckFaultBehindSkips(const EngravingInputs& inputs) {
  if (!starts_again_) return;
  ChainLinks links = LinksNow(inputs);
  // A run that came too late is no fault of this one.
  if (!run_.is_executed(inputs.motion) && inputs.motion.is_cleared_by_a_run())
    links.motion_without_fault = true;
  const Missing missing = FirstMissing(links, false);
  if (missing == Missing::kNothing || missing == Missing::kPermission) return;
  Explain({missing, TextFor(missing), true}, inputs.motion.fault);
}

// In lockstep no undecided tick passes: a lamp warms up by ticks, and a stage brakes by
// them.
void Engraving::SendIdleTicks() {
  if (!horizon_.lockstep() || !laser_.CanSend()) return;
  if (!settling_.AwaitsDisarm()) ticks_.SendIdle(horizon_.IdleTicks());
}

// While the line is up the next turn tries again: no other host will switch the lamp off.
void Engraving::Finish() {
  if (!stopping_ && !JournalIsWritten()) return;
  const bool sent = laser_.CanSend() && laser_.OpenShutters(0) &&
                    ((stopping_ ? lamp_stays_ : job_.lamp_stays) ||
                     laser_.Lamp(false, job_.plan.rate_hz));
  if (sent || !laser_.up()) phase_ = Phase::kDone;
}

void Engraving::NoteStop(bool lamp_stays) {
  lamp_stays_ = lamp_stays;
  if (phase_ == Phase::kPreparing) Finish();
}

}  // namespace intaglio::synchronizer
