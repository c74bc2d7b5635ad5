#include "services/synchronizer/engraving/engraving_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/counted.h"

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;

// In lockstep: windows that may be on the way without a report.
constexpr std::uint64_t kUnreportedWindows = 4;
constexpr std::uint64_t kLockstepLeadTicks = 4;
constexpr std::uint64_t kTicksToRest = 4;
constexpr int kMaxLateStarts = 5;
// Passes in a row that were broken off over a skipped point before they made any.
constexpr int kMaxFruitlessHalts = 5;

}  // namespace

EngravingRun::EngravingRun(const EngravingJob& job, MotionFeed& feed,
                           TickHorizon& horizon, TickWindows& ticks, PulseRecord& record,
                           Shutters& shutters)
    : job_(job),
      feed_(feed),
      horizon_(horizon),
      ticks_(ticks),
      record_(record),
      shutters_(shutters),
      open_points_(job_.places_mm.empty() ? job_.machine_points_mm : job_.places_mm,
                   record.ledger(), job_.cone, job_.masks) {}

ChannelMask EngravingRun::NextMask() {
  open_points_.Rewind();
  return open_points_.mask() != 0 ? open_points_.mask() : job_.shutter_mask;
}

void EngravingRun::Begin(const EngravingInputs& inputs) {
  record_.SkipRuns(inputs.motion.highest_run);
  record_.BeginRun();
  ++count_;
  passed_by_.reset();
  passed_by_tick_ = 0;
  missed_in_a_row_ = 0;
  fired_points_before_ = record_.fired_point_count();
  ticks_.Begin(horizon_.TickAt(inputs.now), horizon_.lockstep());
  const std::uint64_t lead_ticks =
      horizon_.lockstep() ? kLockstepLeadTicks : horizon_.AheadTicks() << late_starts_;
  TakeSpeed(inputs);
  feed_.SetBlockPlace(job_.block_stage_mm.value_or(Vec2::Zero()));
  feed_.Begin(job_.uid, record_.run(), ticks_.decided() + lead_ticks,
              inputs.motion.position_mm, job_.plan, job_.machine_limits,
              inputs.motion_clock);
  if (!horizon_.has_own_clock()) return;
  clock_steps_ = inputs.motion_clock->steps();
  inputs.motion_clock->BeginRun();
  PlacePulses(inputs);
}

void EngravingRun::PlacePulses(const EngravingInputs& inputs) {
  if (count_ == 0 || !horizon_.has_own_clock()) return;
  const MotionClock* const clock = inputs.motion_clock;
  if (clock != nullptr) ticks_.SetCertain(clock->certain_through(), clock->LateTicks());
  if (ticks_.has_lost_places() || (clock != nullptr && clock->lost_run()))
    ticks_.LosePlaces();
}

std::optional<HaltReason> EngravingRun::Turn(const EngravingInputs& inputs) {
  if (auto reason = WhyHalt(inputs)) return reason;
  FeedMotion(inputs);
  if (auto reason = DecideTicks(inputs)) return reason;
  if (record_.disk_failed()) {
    return HaltReason{Missing::kNothing, record_.disk_error(), true};
  }
  ticks_.SendDurable();
  return std::nullopt;
}

std::optional<HaltReason> EngravingRun::WhyHalt(const EngravingInputs& inputs) {
  if (passed_by_) return WhySkipped();
  // Also when there is nothing to arm any more, as all its ticks have passed meanwhile.
  if (!shutters_.was_seen_open() && shutters_.fails_to_open(inputs.now)) {
    return HaltReason{Missing::kShutter, TextOf(Missing::kShutter), true};
  }
  // A dead beam or a blind sensor would go on through the whole block.
  if (missed_in_a_row_ >= job_.max_missed_in_a_row) {
    return HaltReason{
        Missing::kNothing,
        fmt::format("no crack was detected for {} in a row: check lens, block, "
                    "pulse energy and photosensor, then resume; a job for a machine "
                    "without a photosensor has laser.photosensor_feedback: false",
                    Counted(missed_in_a_row_, "pulse")),
        true};
  }
  if (feed_.dropped()) {
    return HaltReason{Missing::kMotionState,
                      "the motion bridge has dropped the run; resume", true};
  }
  if (horizon_.has_own_clock() &&
      (inputs.motion_clock == nullptr || inputs.motion_clock->steps() != clock_steps_)) {
    return HaltReason{
        Missing::kNothing,
        inputs.motion_clock != nullptr && inputs.motion_clock->lost_run()
            ? "a lamp sync was left out, late or too many: the run starts again"
            : "the clock of the stage controller has changed its rate: the run starts "
              "again",
        false};
  }
  return std::nullopt;
}

// What comes later in the order may lie in the beam of what was passed by, so the run
// starts again there; but not by itself when it was the machine that held a pulse back.
HaltReason EngravingRun::WhySkipped() {
  switch (*passed_by_) {
    case SkipReason::kInterlock:
      return {
          Missing::kDoor,
          "an interlock of the machine blocked a pulse: check key, door, its lock and "
          "stop, then resume",
          true};
    case SkipReason::kLamp:
      return {Missing::kLamp, TextOf(Missing::kLamp), true};
    case SkipReason::kShutter:
      return {Missing::kShutter, TextOf(Missing::kShutter), true};
    case SkipReason::kTrigger:
      return {Missing::kNothing,
              "the Q-switch's trigger came too late or was too short for the laser: "
              "compare laser.timing of the profile with its data sheet, check the cable, "
              "then resume",
              true};
    case SkipReason::kEnergy:
      return {Missing::kNothing,
              fmt::format("the laser does not make pulses of {} mJ: compare "
                          "laser.pulse_energy_mj of the profile with its data sheet, "
                          "then cancel the job and submit it with an energy it has",
                          job_.energies.Of(passed_by_point_)),
              true};
    default:
      break;
  }
  const bool fruitless = record_.fired_point_count() == fired_points_before_;
  fruitless_halts_ = fruitless ? fruitless_halts_ + 1 : 0;
  if (fruitless_halts_ < kMaxFruitlessHalts) {
    return {Missing::kNothing, "pulses were skipped: the run starts again there", false};
  }
  fruitless_halts_ = 0;
  return {Missing::kNothing,
          "the same point was skipped repeatedly: check that the stage follows and the "
          "disk is fast enough, then resume",
          true};
}

void EngravingRun::TakeSpeed(const EngravingInputs& inputs) {
  if (inputs.speed_percent == speed_percent_) return;
  speed_percent_ = inputs.speed_percent;
  min_speed_percent_ = std::min(min_speed_percent_, speed_percent_);
  max_speed_percent_ = std::max(max_speed_percent_, speed_percent_);
  ++speed_changes_;
  feed_.SetSpeed(speed_percent_ / 100.0, ticks_.schedule());
}

void EngravingRun::FeedMotion(const EngravingInputs& inputs) {
  TakeSpeed(inputs);
  const auto next = [this]() -> std::optional<MotionFeed::Target> {
    const auto point = open_points_.Next();
    if (!point) return std::nullopt;
    return MotionFeed::Target{*point, job_.machine_points_mm[*point]};
  };
  std::uint64_t tick = horizon_.TickAt(inputs.now);
  // No further than the controller's clock is known.
  if (horizon_.has_own_clock()) {
    tick = std::min(tick, inputs.motion_clock->newest_tick());
  }
  feed_.Advance(std::max(tick, feed_.start_tick()) + horizon_.AheadTicks(), next,
                ticks_.schedule());
}

std::optional<HaltReason> EngravingRun::DecideTicks(const EngravingInputs& inputs) {
  if (auto late = CheckStart(inputs)) return late;
  const std::uint64_t limit = ArmLimit(inputs);
  const std::uint64_t window = horizon_.WindowTicks();
  while (ticks_.decided() < limit) {
    const std::uint64_t last = std::min(limit, ticks_.decided() + window);
    // A narrow window costs as much as a wide one; wait unless the machine waits for us.
    // So it is with a few points at a time: they are decided as soon as there is room.
    const bool idle =
        job_.max_unsettled_points > 0 ||
        (ticks_.reported_through() >= ticks_.decided() && !ticks_.holds_windows());
    if (horizon_.lockstep() && last - ticks_.decided() < window / 4 && !idle) break;
    if (!shutters_.are_open()) break;
    if (auto reason = ArmThrough(last)) return reason;
  }
  return std::nullopt;
}

// A run that did not reach the stage in time: nothing was armed, so it may start anew.
std::optional<HaltReason> EngravingRun::CheckStart(const EngravingInputs& inputs) {
  if (is_executed(inputs.motion)) {
    late_starts_ = 0;
    return std::nullopt;
  }
  if (horizon_.lockstep() || horizon_.TickAt(inputs.now) < feed_.start_tick()) {
    return std::nullopt;
  }
  if (++late_starts_ > kMaxLateStarts) {
    late_starts_ = 0;
    return HaltReason{Missing::kMotionState,
                      "the motion bridge is too slow to start a run", true};
  }
  return HaltReason{Missing::kNothing, "the run starts again: its start was too late",
                    false};
}

// Through which tick points may be armed: as far as the stage's controller has the
// motion, and no further ahead than is worth a window.
std::uint64_t EngravingRun::ArmLimit(const EngravingInputs& inputs) {
  const bool executed = is_executed(inputs.motion);
  std::uint64_t limit =
      executed ? inputs.motion.covered_through_tick : feed_.start_tick() - 1;
  if (job_.max_unsettled_points > 0) {
    limit = std::min(limit, ticks_.schedule().LastTickFor(job_.max_unsettled_points));
  }
  if (!horizon_.lockstep()) {
    const std::uint64_t now = horizon_.TickAt(inputs.now);
    ticks_.SkipTo(now);
    return std::min(limit, now + horizon_.WindowTicks());
  }
  // By a clock of its own the stage may come to rest a little after its last tick.
  // The stamp that makes its last pulse certain may need more.
  if (horizon_.has_own_clock() && executed && feed_.sent_all())
    limit = ticks_.awaits_places() ? UINT64_MAX : limit + kTicksToRest;
  return std::min(
      limit, ticks_.reported_through() + kUnreportedWindows * horizon_.WindowTicks());
}

std::optional<HaltReason> EngravingRun::ArmThrough(std::uint64_t last) {
  const bool armed = ticks_.Arm(
      last, [this](std::uint32_t point) { return job_.energies.Of(point); },
      [this](std::uint32_t) { passed_by_ = SkipReason::kLate; }, *job_.trigger);
  if (armed) return std::nullopt;
  return HaltReason{Missing::kNothing,
                    record_.disk_failed()
                        ? record_.disk_error()
                        : "the journal's disk does not keep up: the run is stopped",
                    true};
}

void EngravingRun::Note(const PulseResult& result) {
  if (result.outcome == PointOutcome::kSkipped) {
    if (passed_by_) return;
    passed_by_ = result.reason;
    passed_by_tick_ = result.tick;
    passed_by_point_ = result.point;
  } else if (result.outcome == PointOutcome::kMissed) {
    ++missed_in_a_row_;
  } else if (result.outcome == PointOutcome::kMade) {
    missed_in_a_row_ = 0;
  }
}

bool EngravingRun::is_finished(const EngravingInputs& inputs) const {
  return is_executed(inputs.motion) && feed_.sent_all() && ticks_.schedule().empty() &&
         inputs.motion.at_rest && !ticks_.holds_windows() && !ticks_.awaits_places();
}

void EngravingRun::Finish() {
  const bool idle = record_.fired_point_count() == fired_points_before_;
  idle_runs_ = idle ? idle_runs_ + 1 : 0;
}

}  // namespace intaglio::synchronizer
