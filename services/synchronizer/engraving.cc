#include "services/synchronizer/engraving.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using namespace std::chrono_literals;

// In real time the motion is this far ahead, the arms half as far: long enough for the
// journal's disk and a loaded host, short enough that a pause is felt at once.
constexpr double kAheadSeconds = 1.0;
// In lockstep the machine waits for us, so the windows only have to be worth a turn.
constexpr std::uint64_t kLockstepAheadTicks = 4096;
constexpr std::uint64_t kLockstepWindowTicks = 512;
// Passes over points that were skipped, as long as a pass makes at least one.
constexpr int kMaxIdleRuns = 2;
constexpr int kMaxLateStarts = 5;
constexpr auto kRequestPeriod = 20ms;
constexpr auto kShutterTimeout = 2s;

std::string TextFor(Missing missing, const MotionView& motion) {
  return missing == Missing::kMotionFault ? motion.message : TextOf(missing);
}

}  // namespace

Engraving::Engraving(EngravingJob job, LaserController& laser, MotionFeed& feed,
                     JournalWriter& journal, PulseSchedule::ResultSink results)
    : job_(std::move(job)),
      laser_(laser),
      feed_(feed),
      journal_(journal),
      results_(std::move(results)),
      ledger_(job_.machine_points_mm.size()),
      open_points_(job_.machine_points_mm, ledger_, job_.cone_tangent) {}

ChainLinks Engraving::LinksOf(const EngravingInputs& inputs) const {
  ChainLinks links;
  links.permission_fresh = inputs.permission_fresh;
  links.permission_granted = inputs.permission_granted;
  links.stop_not_pressed = !inputs.stop_pressed;
  links.laser_line_up = laser_.up();
  links.key_on = laser_.Has(link::kKeyOn);
  links.door_closed = laser_.Has(link::kDoorClosed);
  links.stop_released = laser_.Has(link::kStopReleased);
  links.no_safe_state = !laser_.Has(link::kSafeState);
  links.lamp_warm = laser_.Has(link::kLampOn) && laser_.Has(link::kLampWarm);
  links.motion_fresh = inputs.motion.fresh;
  links.motion_without_fault = inputs.motion.fault == intaglio_MOTION_OK;
  links.shutters_open =
      (laser_.status().shutters_open & job_.shutter_mask) == job_.shutter_mask;
  return links;
}

std::uint64_t Engraving::TickNow(const EngravingInputs& inputs) const {
  if (laser_.identity().lockstep) return laser_.status().tick;
  return clock_.TickAt(inputs.now);
}

std::uint64_t Engraving::AheadTicks() const {
  if (laser_.identity().lockstep) return kLockstepAheadTicks;
  return static_cast<std::uint64_t>(std::ceil(kAheadSeconds * clock_.ticks_per_s())) + 4;
}

void Engraving::Turn(const EngravingInputs& inputs) {
  now_ = inputs.now;
  motion_fault_ = inputs.motion.fault;
  if (laser_.up() && laser_.status_number() != status_number_) {
    status_number_ = laser_.status_number();
    clock_.Observe(laser_.status(), inputs.now);
  }
  if (!inputs.permission_fresh || !inputs.permission_granted) needs_new_grant_ = false;
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
  schedule_.Apply(report, [this](const PulseResult& result) { Record(result); });
}

void Engraving::Record(const PulseResult& result) {
  const bool fired =
      result.outcome == PointOutcome::kMade || result.outcome == PointOutcome::kMissed;
  if (fired) {
    ++fired_count_;
    if (first_fired_tick_ == 0) first_fired_tick_ = result.tick;
    last_fired_tick_ = result.tick;
  }
  passed_by_ = passed_by_ || result.outcome == PointOutcome::kSkipped;
  ledger_.Resolve(result.point, result.outcome);
  journal_.Append({JournalKind::kOutcome, result.outcome,
                   static_cast<std::uint8_t>(result.reason), run_, result.tick,
                   result.point,
                   static_cast<std::uint32_t>(pulses_before_job_ + fired_count_)});
  results_(result);
}

void Engraving::Prepare(const EngravingInputs& inputs) {
  if (!laser_.up()) {
    message_ = TextOf(Missing::kLaserLine) + ": " + laser_.message();
    lamp_asked_ = false;
    return;
  }
  if (!lamp_asked_ && laser_.CanSend()) {
    lamp_asked_ = laser_.Lamp(true, job_.plan.rate_hz).has_value();
  }
  KeepIdleTicksPassing();
  const bool right_rate = laser_.status().rate_hz == job_.plan.rate_hz;
  if (!laser_.Has(link::kLampWarm) || !right_rate) {
    message_ =
        fmt::format("the lamp warms up: {:.0f} %", 100 * laser_.status().warm_ratio);
    return;
  }
  if (!inputs.motion.fresh || inputs.motion.fault == intaglio_MOTION_LINK_LOST) {
    message_ =
        inputs.motion.fresh ? inputs.motion.message : TextOf(Missing::kMotionState);
    return;
  }
  message_.clear();
  phase_ = Phase::kWaiting;
}

// In lockstep no tick passes that nobody decided, and a lamp warms up by its ticks.
void Engraving::KeepIdleTicksPassing() {
  if (!laser_.identity().lockstep || !laser_.CanSend()) return;
  const link::LaserStatus& status = laser_.status();
  decided_ = std::max({decided_, status.decided_through, status.tick});
  if (laser_.session() != session_)
    decided_ = std::max(status.decided_through, status.tick);
  session_ = laser_.session();
  if (decided_ > status.tick) return;
  link::ArmWindow idle{decided_ + 1, true, std::vector<bool>(link::kMaxArmTicks, false)};
  if (!laser_.Arm(idle)) return;
  decided_ += idle.fire.size();
  (void)laser_.RequestStatus();
}

void Engraving::Await(const EngravingInputs& inputs) {
  if (stopping_ || !ledger_.NextOpen(0) || idle_runs_ >= kMaxIdleRuns) return Finish();
  if (!laser_.up() || !laser_.Has(link::kLampWarm)) {
    phase_ = Phase::kPreparing;
    return;
  }
  ChainLinks links = LinksOf(inputs);
  // A safe state is left on the operator's word, which is the grant; a stage's fault is
  // cleared by the bridge when it begins the run.
  const bool granted = links.permission_fresh && links.permission_granted;
  if (granted && !needs_new_grant_ && !links.no_safe_state && laser_.CanSend() &&
      inputs.now >= next_request_) {
    next_request_ = inputs.now + kRequestPeriod;
    (void)laser_.Reset();
    (void)laser_.RequestStatus();
  }
  if (granted && !needs_new_grant_ && inputs.motion.fault != intaglio_MOTION_LINK_LOST) {
    links.motion_without_fault = true;
  }
  const Missing missing = FirstMissing(links, false);
  if (missing != Missing::kNothing || needs_new_grant_) {
    starts_again_ = false;
    if (!needs_new_grant_) message_ = TextFor(missing, inputs.motion);
    return;
  }
  // How far ahead to plan is not known before the lamp's pace is.
  if (!laser_.identity().lockstep && !clock_.settled()) return;
  StartRun(inputs);
}

void Engraving::StartRun(const EngravingInputs& inputs) {
  if (!laser_.CanSend() || !laser_.OpenShutters(job_.shutter_mask)) return;
  (void)laser_.RequestStatus();
  const link::LaserStatus& status = laser_.status();
  if (run_count_ == 0) {
    pulses_before_job_ = status.pulse_count;
    power_up_ = laser_.identity().power_up;
  }
  session_ = laser_.session();
  run_ = std::max(run_, inputs.motion.highest_run) + 1;
  ++run_count_;
  open_points_.Rewind();
  passed_by_ = false;
  ended_before_run_ =
      ledger_.count(PointState::kMade) + ledger_.count(PointState::kMissed);
  decided_ = std::max({TickNow(inputs), status.decided_through,
                       laser_.identity().lockstep ? decided_ : 0});
  sent_through_ = reported_through_ = decided_;
  windows_.clear();
  const std::uint64_t lead =
      laser_.identity().lockstep ? 4 : AheadTicks() << late_starts_;
  feed_.Begin(job_.uid, run_, decided_ + lead, inputs.motion.position_mm, job_.plan);
  run_began_at_ = inputs.now;
  message_.clear();
  phase_ = Phase::kRunning;
}

void Engraving::Run(const EngravingInputs& inputs) {
  if (stopping_) return Halt(Missing::kNothing, message_, false);
  if (laser_.session() != session_) {
    return Halt(Missing::kLaserLine, TextOf(Missing::kLaserLine), true);
  }
  ChainLinks links = LinksOf(inputs);
  // Until the controller executes this run, a fault is that of an older one, which the
  // bridge clears, or a start that came too late, which is tried again.
  const bool our_run = inputs.motion.run == run_;
  if (!our_run && inputs.motion.fault != intaglio_MOTION_LINK_LOST) {
    links.motion_without_fault = true;
  }
  const Missing missing = FirstMissing(links, false);
  if (missing != Missing::kNothing) {
    const bool fault = missing != Missing::kPermission;
    return Halt(
        missing,
        missing == Missing::kMotionFault ? inputs.motion.message : TextOf(missing),
        fault);
  }
  // What comes later in the order may lie in the beam of what was passed by.
  if (passed_by_) {
    return Halt(Missing::kNothing, "pulses were skipped: the run starts again there",
                false);
  }
  const auto next = [this]() -> std::optional<MotionFeed::Target> {
    const auto point = open_points_.Next();
    if (!point) return std::nullopt;
    return MotionFeed::Target{*point, job_.machine_points_mm[*point]};
  };
  const std::uint64_t from = std::max(TickNow(inputs), feed_.start_tick());
  feed_.Advance(from + AheadTicks(), next, schedule_);
  DecideTicks(inputs);
  if (phase_ != Phase::kRunning) return;
  SendDurableWindows();
  if (our_run && feed_.sent_all() && schedule_.empty() && inputs.motion.at_rest &&
      windows_.empty()) {
    FinishRun();
  }
}

void Engraving::DecideTicks(const EngravingInputs& inputs) {
  const bool lockstep = laser_.identity().lockstep;
  const bool covered = inputs.motion.run == run_;
  const std::uint64_t now = TickNow(inputs);
  if (!covered && !lockstep && now >= feed_.start_tick()) {
    // The run did not reach the stage in time; nothing was armed, so it may start anew.
    if (++late_starts_ > kMaxLateStarts) {
      return Halt(Missing::kMotionState, "the motion bridge is too slow to start a run",
                  true);
    }
    return Halt(Missing::kNothing, "the run is started again: it came too late", false);
  }
  std::uint64_t limit =
      covered ? inputs.motion.covered_through_tick : feed_.start_tick() - 1;
  std::uint64_t window = kLockstepWindowTicks;
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
    if (!LinksOf(inputs).shutters_open) return AwaitShutter(inputs);
    Prearm(decided_ + 1, last);
    decided_ = last;
  }
}

void Engraving::Prearm(std::uint64_t first, std::uint64_t last) {
  Window window;
  window.arm = schedule_.Decide(
      first, last,
      [this](std::uint64_t tick, std::uint32_t point) {
        ledger_.Arm(point);
        journal_.Append(
            {JournalKind::kIntent, PointOutcome::kNone, 0, run_, tick, point, 0});
      },
      [this](std::uint32_t) { passed_by_ = true; });
  window.journal_number = journal_.appended();
  windows_.push_back(std::move(window));
  journal_.Flush();
}

void Engraving::SendDurableWindows() {
  if (journal_.failed()) return Halt(Missing::kNothing, journal_.error(), true);
  while (!windows_.empty() && windows_.front().journal_number <= journal_.durable()) {
    const link::ArmWindow& arm = windows_.front().arm;
    if (!laser_.CanSend() || !laser_.Arm(arm)) return;
    sent_through_ = arm.first_tick + arm.fire.size() - 1;
    windows_.pop_front();
  }
}

void Engraving::AwaitShutter(const EngravingInputs& inputs) {
  if (inputs.now - run_began_at_ > kShutterTimeout) {
    Halt(Missing::kShutter, TextOf(Missing::kShutter), true);
  }
}

void Engraving::FinishRun() {
  const std::uint64_t ended =
      ledger_.count(PointState::kMade) + ledger_.count(PointState::kMissed);
  idle_runs_ = ended == ended_before_run_ ? idle_runs_ + 1 : 0;
  late_starts_ = 0;
  phase_ = Phase::kWaiting;
}

void Engraving::Finish() {
  if (laser_.CanSend()) {
    (void)laser_.OpenShutters(0);
    (void)laser_.Lamp(false, job_.plan.rate_hz);
  }
  phase_ = Phase::kDone;
}

void Engraving::Stop(const std::string& why) {
  stopping_ = true;
  message_ = why;
  if (phase_ == Phase::kPreparing) Finish();
}

}  // namespace intaglio::synchronizer
