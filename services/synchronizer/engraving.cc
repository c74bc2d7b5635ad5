#include "services/synchronizer/engraving.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;

// In real time the motion is this far ahead, the arms half as far: long enough for the
// journal's disk and a loaded host, short enough that a pause is felt at once.
constexpr double kAheadSeconds = 1.0;
// In lockstep the machine waits for us, so the windows only have to be worth a turn.
constexpr std::uint64_t kLockstepAheadTicks = 4096;
constexpr std::uint64_t kLockstepWindowTicks = 512;
// With a clock of its own also the controller's time is extrapolated that far.
constexpr std::uint64_t kLeastOwnClockTicks = 64;
constexpr std::uint64_t kTicksToRest = 4;
constexpr int kMaxLateStarts = 5;

std::string TextFor(Missing missing, const MotionView& motion) {
  return missing == Missing::kMotionFault ? motion.message : TextOf(missing);
}

}  // namespace

Engraving::Engraving(EngravingJob job, LaserController& laser, MotionFeed& feed,
                     JournalWriter& journal, PermissionChain& chain,
                     PulseSchedule::ResultSink results)
    : job_(std::move(job)),
      laser_(laser),
      feed_(feed),
      chain_(chain),
      results_(std::move(results)),
      record_(job_.machine_points_mm.size(), job_.photosensor_feedback, journal,
              [this](const PulseResult& result) { Note(result); }),
      open_points_(job_.machine_points_mm, record_.ledger(), job_.cone_tangent,
                   job_.masks),
      shutters_(laser),
      consent_(job_, record_, chain_) {
  // Armed before there was a path, and spent before it came.
  if (chain_.has_spent()) message_ = TextOf(chain_.spent_by());
  if (!job_.earlier.points.empty()) TakeUp();
}

std::uint64_t Engraving::TickNow(const EngravingInputs& inputs) const {
  if (laser_.identity().lockstep) return laser_.status().tick;
  return clock_.TickAt(inputs.now);
}

std::uint64_t Engraving::AheadTicks() const {
  if (laser_.identity().lockstep) {
    if (!own_clock_) return kLockstepAheadTicks;
    return std::clamp(static_cast<std::uint64_t>(kAheadSeconds * job_.plan.rate_hz),
                      kLeastOwnClockTicks, kLockstepAheadTicks);
  }
  return static_cast<std::uint64_t>(std::ceil(kAheadSeconds * clock_.ticks_per_s())) + 4;
}

void Engraving::Turn(const EngravingInputs& inputs) {
  now_ = inputs.now;
  motion_fault_ = inputs.motion.fault;
  granted_ = inputs.permission_granted;
  grant_heard_ = inputs.grant.number > 0;
  const std::pair status_number{laser_.session(), laser_.status_number()};
  if (laser_.up() && status_number != status_number_) {
    status_number_ = status_number;
    clock_.Observe(laser_.status(), inputs.now);
  }
  HearDisarmed();
  TurnChain(inputs);
  HaltOverOtherDevice(inputs);
  if (!stopping_) consent_.TakeConsent(inputs, phase_ == Phase::kHalting);
  AskOverUncertain(inputs);
  // While it runs every window flushes; afterwards the last outcomes would wait for long.
  if (phase_ != Phase::kRunning) record_.FlushAppended();
  switch (phase_) {
    case Phase::kPreparing:
      return Prepare(inputs);
    case Phase::kWaiting:
      return Await(inputs);
    case Phase::kRunning:
      return Run(inputs);
    case Phase::kHalting:
      return SettleHalted(inputs);
    case Phase::kDone:
      return;
  }
}

void Engraving::Take(const link::PulseReport& report) {
  if (report.outcome.empty()) return;
  reported_through_ =
      std::max(reported_through_, report.first_tick + report.outcome.size() - 1);
  schedule_.Apply(report, [this](const PulseResult& result) { record_.Resolve(result); });
}

void Engraving::Await(const EngravingInputs& inputs) {
  if (stopping_ || NothingIsLeft(inputs)) return Finish();
  if (!laser_.up() || !laser_.Has(link::kLampWarm) || !job_.block_misfit.empty()) {
    phase_ = Phase::kPreparing;
    return;
  }
  LeaveSafeState(inputs);
  // In lockstep it brakes only while ticks pass, which in a safe state none does.
  const bool seen = inputs.motion.fresh && !inputs.motion.line_down();
  if (seen && !inputs.motion.at_rest) {
    AbortEarlierRun(inputs);
    KeepIdleTicksPassing();
  }
  ChainLinks links = LinksNow(inputs);
  // A stage's fault is cleared by the bridge when it begins the run.
  if (!chain_.latched() && !inputs.motion.line_down()) {
    links.motion_without_fault = true;
  }
  const bool closed = shutters_.KeepClosed(inputs.now);
  const Missing missing = chain_.WhatIsMissing(links, false);
  if (missing != Missing::kNothing) {
    starts_again_ = false;
    if (!faulted()) message_ = TextFor(missing, inputs.motion);
    return;
  }
  // How far ahead to plan is not known before the lamp's pace is.
  if (!laser_.identity().lockstep && !clock_.settled()) return;
  if (!MotionClockSettles(inputs)) return;
  // The plan begins where the stage stands, and with a shutter that is seen to open.
  if (shutters_.fails_to_close(inputs.now)) {
    message_ = "a shutter does not close: see to it, then the job goes on";
  }
  if (!closed || !inputs.motion.at_rest) return;
  bool reopened_any = false;
  const bool all_open =
      record_.LeaveOutBefore(inputs.first_point) && consent_.Reopen(inputs, reopened_any);
  if (reopened_any) idle_runs_ = 0;
  if (all_open && JournalIsWritten()) StartRun(inputs);
}

// Also when nothing is open any more: it costs the grant, as a fault does, and the answer
// is a newer one. Before any was received, there is none that could be spent.
void Engraving::AskOverUncertain(const EngravingInputs& inputs) {
  const bool settled = phase_ == Phase::kPreparing || phase_ == Phase::kWaiting;
  if (stopping_ || !settled || !consent_.MustAsk(inputs)) return;
  const std::string why = faulted() && !lost_a_line_ ? message_ + "; " : "";
  Explain(Missing::kNothing, why + consent_.Question(), true);
  consent_.NoteAsked();
}

bool Engraving::NothingIsLeft(const EngravingInputs& inputs) const {
  if (consent_.KeepsJobOpen(inputs)) return false;
  return !record_.ledger().NextOpen(0) || idle_runs_ >= kMaxIdleRuns;
}

// With room for what a run appends, and nothing that only this process knows.
bool Engraving::JournalIsWritten() {
  if (record_.is_durable()) return true;
  if (record_.disk_failed()) message_ = record_.disk_error();
  return false;
}

void Engraving::StartRun(const EngravingInputs& inputs) {
  if (!shutters_.Open(MaskOfNextRun(), inputs.now)) return;
  const link::LaserStatus& status = laser_.status();
  if (!started() || record_.power_up() != laser_.identity().power_up) {
    record_.TakeCounters(laser_);
  }
  record_.AcceptOpenings(laser_, chain_.counters().openings);
  session_ = laser_.session();
  record_.SkipRuns(inputs.motion.highest_run);
  record_.BeginRun();
  ++run_count_;
  consent_.BeginRun();
  passed_by_ = false;
  missed_in_a_row_ = 0;
  passed_by_tick_ = 0;
  ended_before_run_ = record_.fired_point_count();
  decided_ = std::max({TickNow(inputs), status.decided_through,
                       laser_.identity().lockstep ? decided_ : 0});
  sent_through_ = reported_through_ = decided_;
  windows_.clear();
  const std::uint64_t lead =
      laser_.identity().lockstep ? 4 : AheadTicks() << late_starts_;
  TakeSpeed(inputs);
  feed_.Begin(job_.uid, record_.run(), decided_ + lead, inputs.motion.position_mm,
              job_.plan, inputs.motion_clock);
  if (own_clock_) clock_steps_ = inputs.motion_clock->steps();
  message_.clear();
  phase_ = Phase::kRunning;
}

void Engraving::Run(const EngravingInputs& inputs) {
  if (stopping_) return Halt(Missing::kNothing, message_, false);
  if (laser_.session() != session_) {
    return Halt(Missing::kLaserLine, TextOf(Missing::kLaserLine), true);
  }
  ChainLinks links = LinksNow(inputs);
  // Until the controller executes this run, a fault is that of an older one, which the
  // bridge clears, or a start that came too late, which is tried again.
  const bool our_run = inputs.motion.run == record_.run();
  if (!our_run && !inputs.motion.line_down()) {
    links.motion_without_fault = true;
  }
  const Missing missing = chain_.WhatIsMissing(links, shutters_.UpdateSeenOpen());
  if (missing != Missing::kNothing) {
    const bool fault = missing != Missing::kPermission;
    return Halt(
        missing,
        missing == Missing::kMotionFault ? inputs.motion.message : TextOf(missing),
        fault);
  }
  if (passed_by_) return HaltOverSkipped();
  if (missed_in_a_row_ >= job_.max_missed_in_a_row) return HaltOverMissed();
  if (feed_.dropped()) {
    return Halt(Missing::kMotionState, "the motion bridge has dropped the run; resume",
                true);
  }
  if (own_clock_ &&
      (inputs.motion_clock == nullptr || inputs.motion_clock->steps() != clock_steps_)) {
    return Halt(
        Missing::kNothing,
        "the clock of the stage's controller has changed its pace: the run starts "
        "again",
        false);
  }
  FeedMotion(inputs);
  DecideTicks(inputs);
  if (phase_ != Phase::kRunning) return;
  SendDurableWindows();
  if (our_run && feed_.sent_all() && schedule_.empty() && inputs.motion.at_rest &&
      windows_.empty()) {
    FinishRun();
  }
}

void Engraving::TakeSpeed(const EngravingInputs& inputs) {
  if (inputs.speed_percent == speed_percent_) return;
  speed_percent_ = inputs.speed_percent;
  least_speed_percent_ = std::min(least_speed_percent_, speed_percent_);
  ++speed_changes_;
  feed_.SetSpeed(speed_percent_ / 100.0, schedule_);
}

void Engraving::FeedMotion(const EngravingInputs& inputs) {
  TakeSpeed(inputs);
  const auto next = [this]() -> std::optional<MotionFeed::Target> {
    const auto point = open_points_.Next();
    if (!point) return std::nullopt;
    return MotionFeed::Target{*point, job_.machine_points_mm[*point]};
  };
  std::uint64_t now = TickNow(inputs);
  // No further than the controller's clock is known.
  if (own_clock_) now = std::min(now, inputs.motion_clock->newest_tick());
  feed_.Advance(std::max(now, feed_.start_tick()) + AheadTicks(), next, schedule_);
}

void Engraving::DecideTicks(const EngravingInputs& inputs) {
  const bool lockstep = laser_.identity().lockstep;
  const bool covered = inputs.motion.run == record_.run();
  const std::uint64_t now = TickNow(inputs);
  if (!covered && !lockstep && now >= feed_.start_tick()) {
    // The run did not reach the stage in time; nothing was armed, so it may start anew.
    if (++late_starts_ > kMaxLateStarts) {
      late_starts_ = 0;
      return Halt(Missing::kMotionState, "the motion bridge is too slow to start a run",
                  true);
    }
    return Halt(Missing::kNothing, "the run is started again: it came too late", false);
  }
  if (covered) late_starts_ = 0;
  std::uint64_t limit =
      covered ? inputs.motion.covered_through_tick : feed_.start_tick() - 1;
  std::uint64_t window = kLockstepWindowTicks;
  // By a clock of its own the stage may come to rest a little after its last tick.
  if (lockstep && own_clock_ && covered && feed_.sent_all()) limit += kTicksToRest;
  if (lockstep) {
    limit = std::min(limit, reported_through_ + 4 * window);
  } else {
    window = std::clamp<std::uint64_t>(AheadTicks() / 2, 2, link::kMaxArmTicks);
    limit = std::min(limit, now + window);
    decided_ = std::max(decided_, now);
  }
  while (decided_ < limit) {
    const std::uint64_t last = std::min(limit, decided_ + window);
    // A narrow window costs as much as a wide one; wait unless the machine waits for us.
    const bool idle = reported_through_ >= decided_ && windows_.empty();
    if (lockstep && last - decided_ < window / 4 && !idle) return;
    if (!shutters_.are_open()) return AwaitShutter(inputs);
    if (!Prearm(decided_ + 1, last)) return;
    decided_ = last;
  }
}

bool Engraving::Prearm(std::uint64_t first, std::uint64_t last) {
  Window window;
  bool kept = true;
  window.arm = schedule_.Decide(
      first, last,
      [&](std::uint64_t tick, std::uint32_t point) { kept &= record_.Arm(tick, point); },
      [this](std::uint32_t) {
        passed_by_ = true;
        passed_by_reason_ = SkipReason::kLate;
      });
  if (!kept || record_.disk_failed()) {
    Halt(Missing::kNothing,
         record_.disk_failed()
             ? record_.disk_error()
             : "the journal's disk does not keep up: the run is stopped",
         true);
    return false;
  }
  window.journal_number = record_.appended();
  windows_.push_back(std::move(window));
  record_.Flush();
  return true;
}

void Engraving::SendDurableWindows() {
  if (record_.disk_failed()) return Halt(Missing::kNothing, record_.disk_error(), true);
  while (!windows_.empty() && windows_.front().journal_number <= record_.durable()) {
    const link::ArmWindow& arm = windows_.front().arm;
    if (!laser_.CanSend() || !laser_.Arm(arm)) return;
    sent_through_ = arm.first_tick + arm.fire.size() - 1;
    windows_.pop_front();
  }
}

void Engraving::AwaitShutter(const EngravingInputs& inputs) {
  if (shutters_.fails_to_open(inputs.now)) {
    Halt(Missing::kShutter, TextOf(Missing::kShutter), true);
  }
}

void Engraving::FinishRun() {
  const bool idle = record_.fired_point_count() == ended_before_run_;
  idle_runs_ = idle ? idle_runs_ + 1 : 0;
  phase_ = Phase::kWaiting;
}

// While the line is up the next turn tries again: nobody comes after it to say "off".
void Engraving::Finish() {
  if (!stopping_ && !JournalIsWritten()) return;
  const bool told = laser_.CanSend() && laser_.OpenShutters(0) &&
                    (lamp_stays_ || laser_.Lamp(false, job_.plan.rate_hz));
  if (told || !laser_.up()) phase_ = Phase::kDone;
}

void Engraving::Stop(const std::string& why, bool lamp_stays) {
  stopping_ = true;
  lamp_stays_ = lamp_stays;
  message_ = why;
  if (phase_ == Phase::kPreparing) Finish();
}

}  // namespace intaglio::synchronizer
