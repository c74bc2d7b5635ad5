#include <fmt/format.h>

#include <algorithm>

#include "services/synchronizer/engraving.h"

// What became of points, also of those whose reports never came: a line was lost, or an
// earlier life of this process. The controller's memory is the truth, its counter the
// check of it.

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using namespace std::chrono_literals;

constexpr auto kAbortPeriod = 200ms;

}  // namespace

void Engraving::Record(PulseResult result) {
  if (result.outcome == PointOutcome::kMissed && !job_.photosensor_feedback) {
    result.outcome = PointOutcome::kMade;
  }
  if (formats::IsFired(result.outcome)) {
    ++fired_count_;
    if (first_fired_tick_ == 0) first_fired_tick_ = result.tick;
    last_fired_tick_ = result.tick;
  }
  if (!passed_by_ && result.outcome == PointOutcome::kSkipped) {
    passed_by_ = true;
    passed_by_reason_ = result.reason;
    passed_by_tick_ = result.tick;
  }
  if (result.outcome == PointOutcome::kMissed) ++missed_in_a_row_;
  if (result.outcome == PointOutcome::kMade) missed_in_a_row_ = 0;
  if (result.outcome == PointOutcome::kUncertain && job_.asks_when_uncertain) {
    asks_ = true;
    asked_ = false;
  }
  ledger_.Resolve(result.point, result.outcome);
  journal_.Append({JournalKind::kOutcome, result.outcome,
                   static_cast<std::uint8_t>(result.reason), run_, result.tick,
                   result.point, pulses_before_job_ + fired_count_});
  results_(result);
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
  run_ = earlier.highest_run;
  power_up_ = earlier.power_up;
  pulses_before_job_ = earlier.pulses_before_job;
  openings_accepted_ = earlier.openings;
  std::vector<PulseResult> armed;
  for (std::uint32_t point = 0; point < earlier.points.size(); ++point) {
    const formats::PointHistory& history = earlier.points[point];
    if (history.reopened) {
      ledger_.Arm(point);
      ledger_.Resolve(point, PointOutcome::kUncertain);
      ledger_.Reopen(point);
    }
    if (history.open_intent) {
      ledger_.Arm(point);
      armed.push_back({history.tick, point});
    } else if (history.outcome == PointOutcome::kLeftOut) {
      ledger_.LeaveOut(point);
    } else if (history.outcome != PointOutcome::kNone) {
      ledger_.Arm(point);
      ledger_.Resolve(point, history.outcome);
      if (formats::IsFired(history.outcome)) ++fired_count_;
    }
  }
  asks_ = job_.asks_when_uncertain && earlier.uncertain_unanswered &&
          ledger_.count(PointState::kUncertain) > 0;
  std::sort(armed.begin(), armed.end(), [](const auto& a, const auto& b) {
    return std::pair(a.tick, a.point) < std::pair(b.tick, b.point);
  });
  for (PulseResult& one : armed) {
    const bool askable =
        power_up_ != 0 && earlier.points[one.point].power_up == power_up_;
    if (askable && schedule_.AddArmed(one.tick, one.point)) continue;
    one.outcome = PointOutcome::kUncertain;
    Record(one);
  }
  uncertain_before_halt_ = ledger_.count(PointState::kUncertain);
}

// Nobody feeds the stage any more; in lockstep it would wait for ever.
void Engraving::AbortEarlierRun(const EngravingInputs& inputs) {
  if (run_count_ > 0 || !inputs.motion.fresh || inputs.motion.at_rest ||
      inputs.now < next_abort_) {
    return;
  }
  next_abort_ = inputs.now + kAbortPeriod;
  run_ = std::max(run_, inputs.motion.highest_run);
  (void)feed_.Abort(run_);
}

// In the session that armed them, ticks behind the last decided one never fire, and the
// reports of the others were sent before that status.
void Engraving::SettleByMemory(bool late) {
  if (laser_.identity().power_up != power_up_) {
    SettleAs(schedule_.ArmedWithin(0, UINT64_MAX), PointOutcome::kUncertain);
    return TakeCounters();
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
    Record(result);
  });
}

// A pulse that the controller counted and nobody asked for is in the glass somewhere. Of
// a journal whose end is gone it made the next points, as they are fired in the order.
void Engraving::CompareCounters() {
  const auto counted = static_cast<std::uint32_t>(laser_.status().pulse_count);
  const std::uint32_t known = pulses_before_job_ + fired_count_;
  const bool explained = ledger_.count(PointState::kUncertain) > uncertain_before_halt_;
  if (counted != known && !explained && doubts_left_ == 0) {
    const std::uint32_t more = counted - known;
    if (taken_up_ && run_count_ == 0 && more <= ledger_.size()) doubts_left_ = more;
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
  if (DoubtNextPoints()) TakeCounters();
}

// They may be more than the journal's ring takes at once; false: the next turns go on.
bool Engraving::DoubtNextPoints() {
  for (auto point = ledger_.NextOpen(0); doubts_left_ > 0 && point;
       point = ledger_.NextOpen(*point)) {
    const auto link = static_cast<std::uint8_t>(SkipReason::kLink);
    if (!journal_.Append({JournalKind::kOutcome, PointOutcome::kUncertain, link, run_, 0,
                          *point, pulses_before_job_ + fired_count_})) {
      return false;
    }
    ledger_.Arm(*point);
    ledger_.Resolve(*point, PointOutcome::kUncertain);
    results_({0, *point, PointOutcome::kUncertain, SkipReason::kLink});
    asks_ = job_.asks_when_uncertain;
    asked_ = false;
    --doubts_left_;
  }
  doubts_left_ = 0;
  return true;
}

// With nothing armed they begin afresh: else the pulses of uncertain points would be
// taken for some of the next lost line.
void Engraving::TakeCounters() {
  const std::uint32_t before =
      static_cast<std::uint32_t>(laser_.status().pulse_count) - fired_count_;
  const bool same_power_up = power_up_ == laser_.identity().power_up;
  if (same_power_up && pulses_before_job_ == before && session_told_) return;
  if (!same_power_up) openings_accepted_ = 0;
  power_up_ = laser_.identity().power_up;
  pulses_before_job_ = before;
  TellSession();
}

void Engraving::TellSession() {
  session_told_ = true;
  journal_.Append({JournalKind::kSession, PointOutcome::kNone, 0, run_,
                   laser_.status().tick, power_up_, pulses_before_job_,
                   openings_accepted_});
}

}  // namespace intaglio::synchronizer
