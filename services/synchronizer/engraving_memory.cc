#include <fmt/format.h>

#include <algorithm>

#include "services/synchronizer/engraving.h"

// What became of points, also of those whose reports never came: a line was lost, or an
// earlier life of this process. The controller's memory is the truth, its counter the
// check of it.

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using namespace std::chrono_literals;

constexpr auto kAbortPeriod = 200ms;

}  // namespace

void Engraving::Note(const PulseResult& result) {
  if (result.reason != SkipReason::kLeftOut) NoteInRun(result);
  consent_.Note(result);
  results_(result);
}

void Engraving::NoteInRun(const PulseResult& result) {
  if (!passed_by_ && result.outcome == PointOutcome::kSkipped) {
    passed_by_ = true;
    passed_by_reason_ = result.reason;
    passed_by_tick_ = result.tick;
  }
  if (result.outcome == PointOutcome::kMissed) ++missed_in_a_row_;
  if (result.outcome == PointOutcome::kMade) missed_in_a_row_ = 0;
}

// The ledger as the journal has it. What was armed is asked of the controller if it has
// not been switched off since; else nobody knows, and it is not fired again by
// itself.
void Engraving::TakeUp() {
  taken_up_ = true;
  phase_ = Phase::kHalting;
  skip_reason_ = SkipReason::kLink;
  message_ = "the job is taken up again: what was armed is asked of the laser controller";
  const EarlierWork& earlier = job_.earlier;
  std::vector<PulseResult> armed = record_.TakeUp(earlier);
  consent_.TakeUp();
  for (PulseResult& one : armed) {
    const bool askable = record_.power_up() != 0 &&
                         earlier.points[one.point].power_up == record_.power_up();
    if (askable && schedule_.AddArmed(one.tick, one.point)) continue;
    one.outcome = PointOutcome::kUncertain;
    record_.Resolve(one);
  }
  uncertain_before_halt_ = record_.ledger().count(PointState::kUncertain);
}

// Nobody feeds the stage any more; in lockstep it would wait for ever.
void Engraving::AbortEarlierRun(const EngravingInputs& inputs) {
  if (run_count_ > 0 || !inputs.motion.fresh || inputs.motion.at_rest ||
      inputs.now < next_abort_) {
    return;
  }
  next_abort_ = inputs.now + kAbortPeriod;
  record_.SkipRuns(inputs.motion.highest_run);
  (void)feed_.Abort(record_.run());
}

// In the session that armed them, ticks behind the last decided one never fire, and the
// reports of the others were sent before that status.
void Engraving::SettleByMemory(bool late) {
  if (laser_.identity().power_up != record_.power_up()) {
    SettleAs(schedule_.ArmedWithin(0, UINT64_MAX), PointOutcome::kUncertain);
    return record_.TakeCounters(laser_);
  }
  const bool lost = laser_.session() != session_;
  if (!lost) {
    SettleAs(schedule_.ArmedWithin(laser_.status().decided_through + 1, UINT64_MAX),
             PointOutcome::kSkipped);
  }
  if (schedule_.armed_count() > 0 && (lost || late)) return AskForThePast();
  // What it finds costs a grant: there is none before it is heard.
  if (lost && schedule_.armed_count() == 0 && grant_heard_) CompareCounters();
}

void Engraving::AskForThePast() {
  if (now_ < next_past_ || !laser_.CanSend()) return;
  next_past_ = now_ + kRequestPeriod;
  const std::uint64_t first = schedule_.front_tick();
  const auto asked = schedule_.ArmedWithin(first, first + link::kMaxReportTicks - 1);
  if (asked.empty()) return;
  (void)laser_.RequestPast(first,
                           static_cast<std::uint16_t>(asked.back().tick - first + 1));
}

void Engraving::Take(const link::PastReport& report) {
  if (phase_ != Phase::kHalting || !disarm_seen_) return;
  schedule_.Apply(report, [this](const PulseResult& result) {
    if (formats::IsFired(result.outcome)) ++settled_by_memory_;
    record_.Resolve(result);
  });
}

// A pulse that the controller counted and nobody asked for is in the glass somewhere. Of
// a journal whose end is gone it made the next points, as they are fired in the order.
void Engraving::CompareCounters() {
  const auto counted = static_cast<std::uint32_t>(laser_.status().pulse_count);
  const std::uint32_t known = record_.known_pulse_count();
  const bool explained =
      record_.ledger().count(PointState::kUncertain) > uncertain_before_halt_;
  if (counted != known && !explained && doubts_left_ == 0) {
    const std::uint32_t more = counted - known;
    if (taken_up_ && run_count_ == 0 && more <= record_.ledger().size())
      doubts_left_ = more;
    Explain(Missing::kNothing,
            fmt::format(
                "the laser controller counts {} pulses where {} are known{}: "
                "look at the block, then resume or cancel",
                counted, known,
                doubts_left_ == 0
                    ? ""
                    : fmt::format(", so the next {} points are uncertain", doubts_left_)),
            true);
  }
  if (DoubtNextPoints()) record_.TakeCounters(laser_);
}

// They may be more than the journal's ring takes at once; false: the next turns go on.
bool Engraving::DoubtNextPoints() {
  for (auto point = record_.ledger().NextOpen(0); doubts_left_ > 0 && point;
       point = record_.ledger().NextOpen(*point)) {
    if (!record_.MarkUncertain(*point)) return false;
    --doubts_left_;
  }
  doubts_left_ = 0;
  return true;
}

}  // namespace intaglio::synchronizer
