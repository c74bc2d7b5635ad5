#include "engrave/proof/mark_account.h"

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

using formats::PointHistory;
using formats::PointOutcome;

bool IsOpen(const PointHistory& mark) { return mark.open_intent || mark.reopened; }

bool HasEnded(const PointHistory& mark) {
  return formats::IsFired(mark.outcome) && !mark.open_intent;
}

bool IsUncertain(const PointHistory& mark) {
  return !HasEnded(mark) && (IsOpen(mark) || mark.outcome == PointOutcome::kUncertain);
}

bool WasBegun(const PointHistory& mark) { return HasEnded(mark) || IsUncertain(mark); }

AccountedMark ByMaterial(const PointHistory& journal, BurntFate burnt) {
  AccountedMark mark;
  mark.uncertain = IsUncertain(journal);
  mark.unaccounted = burnt != BurntFate::kMissed && !WasBegun(journal);
  switch (burnt) {
    case BurntFate::kMissed:
      mark.outcome = WasBegun(journal) ? MarkOutcome::kMissed : MarkOutcome::kSkipped;
      break;
    case BurntFate::kIncomplete:
      mark.outcome = MarkOutcome::kIncomplete;
      break;
    case BurntFate::kMade:
      mark.outcome = MarkOutcome::kMade;
      break;
    case BurntFate::kDoubled:
      mark.outcome = MarkOutcome::kDoubled;
      break;
  }
  return mark;
}

AccountedMark ByJournal(const PointHistory& journal) {
  if (IsUncertain(journal)) return {MarkOutcome::kUncertain, true, false};
  if (!HasEnded(journal)) return {MarkOutcome::kSkipped, false, false};
  if (journal.fired_count > 1) return {MarkOutcome::kDoubled, false, false};
  return {
      journal.outcome == PointOutcome::kMade ? MarkOutcome::kMade : MarkOutcome::kMissed,
      false, false};
}

void Add(MarkOutcome outcome, MarkCount& count) {
  count.made += outcome == MarkOutcome::kMade;
  count.skipped += outcome == MarkOutcome::kSkipped;
  count.missed += outcome == MarkOutcome::kMissed;
  count.incomplete += outcome == MarkOutcome::kIncomplete;
  count.doubled += outcome == MarkOutcome::kDoubled;
}

void Add(const AccountedMark& mark, MarkAccount& account) {
  account.marks.push_back(mark);
  Add(mark.outcome, account.count);
  account.uncertain_count += mark.uncertain;
  account.unaccounted_count += mark.unaccounted;
  if (mark.uncertain) Add(mark.outcome, account.of_uncertain);
}

}  // namespace

MarkAccount AccountMarks(std::span<const PointHistory> history,
                         const MarkComparison& burnt) {
  Require(history.size() == burnt.marks.size(), "{} marks in the journal, {} compared",
          history.size(), burnt.marks.size());
  MarkAccount account;
  for (std::size_t i = 0; i < history.size(); ++i)
    Add(ByMaterial(history[i], burnt.marks[i].fate), account);
  return account;
}

MarkAccount AccountMarks(std::span<const PointHistory> history) {
  MarkAccount account;
  for (const PointHistory& mark : history) Add(ByJournal(mark), account);
  return account;
}

}  // namespace intaglio::proof
