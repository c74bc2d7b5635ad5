#include "services/synchronizer/pulses/pulse_record.h"

#include <algorithm>
#include <utility>

namespace intaglio::synchronizer {

using formats::JournalKind;
using formats::PointOutcome;

PulseRecord::PulseRecord(std::size_t point_count, bool photosensor_feedback,
                         JournalWriter& journal, PulseSchedule::ResultSink results)
    : journal_(journal),
      results_(std::move(results)),
      photosensor_feedback_(photosensor_feedback),
      ledger_(point_count) {}

std::vector<PulseResult> PulseRecord::TakeUp(const EarlierWork& earlier) {
  run_ = earlier.highest_run;
  unrecorded_runs_ = 1;
  power_up_ = earlier.power_up;
  pulses_before_job_ = earlier.pulses_before_job;
  openings_accepted_ = earlier.openings;
  fired_ticks_.TakeUp(earlier.points, earlier.power_up);
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
  std::sort(armed.begin(), armed.end(), [](const auto& a, const auto& b) {
    return std::pair(a.tick, a.point) < std::pair(b.tick, b.point);
  });
  return armed;
}

bool PulseRecord::Arm(std::uint64_t tick, std::uint32_t point) {
  ledger_.Arm(point);
  return journal_.Append(
      {JournalKind::kIntent, PointOutcome::kNone, 0, run_, tick, point, 0});
}

void PulseRecord::Resolve(PulseResult result) {
  if (result.outcome == PointOutcome::kMissed && !photosensor_feedback_) {
    result.outcome = PointOutcome::kMade;
    result.missed_channels = 0;
  }
  if (formats::IsFired(result.outcome)) {
    ++fired_count_;
    fired_ticks_.Add(result.tick);
  }
  leaves_out_pulses_ |= result.outcome == PointOutcome::kUncertain &&
                        result.reason == SkipReason::kPosition;
  ledger_.Resolve(result.point, result.outcome);
  journal_.Append({JournalKind::kOutcome, result.outcome,
                   static_cast<std::uint8_t>(result.reason), run_, result.tick,
                   result.point, known_pulse_count(), 0, result.missed_channels,
                   result.measured_mj});
  results_(result);
}

bool PulseRecord::MarkUncertain(std::uint32_t point, SkipReason reason) {
  if (!journal_.Append({JournalKind::kOutcome, PointOutcome::kUncertain,
                        static_cast<std::uint8_t>(reason), run_, 0, point,
                        known_pulse_count()})) {
    return false;
  }
  ledger_.Arm(point);
  ledger_.Resolve(point, PointOutcome::kUncertain);
  results_({0, point, PointOutcome::kUncertain, reason});
  return true;
}

bool PulseRecord::LeaveOutBefore(std::uint32_t point) {
  for (auto next = ledger_.NextOpen(left_out_before_); next && *next < point;
       next = ledger_.NextOpen(*next)) {
    if (!journal_.Append({JournalKind::kOutcome, PointOutcome::kLeftOut,
                          static_cast<std::uint8_t>(SkipReason::kLeftOut), run_, 0, *next,
                          known_pulse_count()})) {
      return false;
    }
    ledger_.LeaveOut(*next);
    results_({0, *next, PointOutcome::kSkipped, SkipReason::kLeftOut});
    left_out_before_ = *next + 1;
  }
  return true;
}

bool PulseRecord::KeepConsent(std::uint64_t grant_number) {
  return journal_.Append({JournalKind::kConsent, PointOutcome::kNone, 0, run_,
                          grant_number, 0, known_pulse_count()});
}

bool PulseRecord::Reopen(std::uint32_t point, std::uint64_t grant_number) {
  if (!journal_.Append({JournalKind::kReopened, PointOutcome::kNone, 0, run_,
                        grant_number, point, known_pulse_count()})) {
    return false;
  }
  ledger_.Reopen(point);
  return true;
}

void PulseRecord::TakeCounters(const drivers::LaserController& laser) {
  leaves_out_pulses_ = false;
  const std::uint32_t before =
      static_cast<std::uint32_t>(laser.status().pulse_count) - fired_count_;
  const bool same_power_up = power_up_ == laser.identity().power_up;
  if (same_power_up && pulses_before_job_ == before && session_journaled_) return;
  if (!same_power_up) {
    openings_accepted_ = 0;
    fired_ticks_.BeginPowerUp();
  }
  power_up_ = laser.identity().power_up;
  pulses_before_job_ = before;
  JournalSession(laser);
}

void PulseRecord::AcceptOpenings(const drivers::LaserController& laser,
                                 std::uint32_t openings) {
  if (openings_accepted_ == openings) return;
  openings_accepted_ = openings;
  JournalSession(laser);
}

void PulseRecord::JournalSession(const drivers::LaserController& laser) {
  session_journaled_ = true;
  journal_.Append({JournalKind::kSession, PointOutcome::kNone, 0, run_,
                   laser.status().tick, power_up_, pulses_before_job_,
                   openings_accepted_});
}

void PulseRecord::FlushAppended() {
  if (flushed_ == journal_.appended()) return;
  flushed_ = journal_.appended();
  journal_.Flush();
}

}  // namespace intaglio::synchronizer
