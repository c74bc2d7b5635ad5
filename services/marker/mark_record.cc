#include "services/marker/mark_record.h"

#include <algorithm>

#include "engrave/formats/journal_file.h"

namespace intaglio::marker {

using formats::JournalKind;
using formats::PointOutcome;

std::uint32_t PowerUpNumber(const std::string& power_up) {
  return formats::PowerUpOfText(power_up);
}

std::vector<ArmedMark> MarkRecord::TakeUp(const cell::EarlierWork& earlier) {
  run_ = earlier.highest_run + 1;
  power_up_ = earlier.power_up;
  openings_ = earlier.openings;
  std::vector<ArmedMark> armed;
  for (std::uint32_t mark = 0; mark < earlier.points.size(); ++mark) {
    const formats::PointHistory& history = earlier.points[mark];
    if (history.reopened) {
      ledger_.Arm(mark);
      ledger_.Resolve(mark, PointOutcome::kUncertain);
      ledger_.Reopen(mark);
    }
    if (history.open_intent) {
      ledger_.Arm(mark);
      armed.push_back({static_cast<std::uint32_t>(history.tick), mark});
    } else if (history.outcome == PointOutcome::kLeftOut) {
      ledger_.LeaveOut(mark);
    } else if (history.outcome != PointOutcome::kNone) {
      ledger_.Arm(mark);
      ledger_.Resolve(mark, history.outcome);
    }
  }
  return armed;
}

std::uint32_t MarkRecord::BeginRun(std::uint32_t newest) {
  return run_ = std::max(run_, newest) + 1;
}

bool MarkRecord::Arm(std::uint32_t mark) {
  if (!journal_.Append({JournalKind::kIntent, PointOutcome::kNone, 0, run_, run_, mark}))
    return false;
  ledger_.Arm(mark);
  return true;
}

// Without room in the ring the intent stays open, and the next life settles it.
void MarkRecord::Resolve(std::uint32_t mark, PointOutcome outcome,
                         formats::MarkSkip why) {
  ledger_.Resolve(mark, outcome);
  (void)journal_.Append(
      {JournalKind::kOutcome, outcome, static_cast<std::uint8_t>(why), run_, run_, mark});
}

bool MarkRecord::LeaveOut(std::uint32_t mark, formats::MarkSkip why) {
  if (!journal_.Append({JournalKind::kOutcome, PointOutcome::kLeftOut,
                        static_cast<std::uint8_t>(why), run_, run_, mark}))
    return false;
  ledger_.LeaveOut(mark);
  return true;
}

bool MarkRecord::LeaveOutBefore(std::uint32_t mark) {
  for (auto next = ledger_.NextOpen(0); next && *next < mark;
       next = ledger_.NextOpen(*next)) {
    if (!LeaveOut(*next, formats::MarkSkip::kNone)) return false;
  }
  return true;
}

bool MarkRecord::KeepConsent(std::uint64_t grant_number) {
  return journal_.Append(
      {JournalKind::kConsent, PointOutcome::kNone, 0, run_, grant_number, 0});
}

bool MarkRecord::Reopen(std::uint32_t mark, std::uint64_t grant_number) {
  if (!journal_.Append(
          {JournalKind::kReopened, PointOutcome::kNone, 0, run_, grant_number, mark})) {
    return false;
  }
  ledger_.Reopen(mark);
  return true;
}

bool MarkRecord::KeepSession(std::uint32_t power_up, std::uint32_t openings) {
  if (session_kept_ && power_up == power_up_ && openings == openings_) return true;
  if (!journal_.Append({JournalKind::kSession, PointOutcome::kNone, 0, run_, 0, power_up,
                        0, openings})) {
    return false;
  }
  session_kept_ = true;
  power_up_ = power_up;
  openings_ = openings;
  return true;
}

void MarkRecord::FlushAppended() {
  if (flushed_ == journal_.appended()) return;
  flushed_ = journal_.appended();
  journal_.Flush();
}

}  // namespace intaglio::marker
