#include "engrave/proof/mark_account.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

using formats::PointHistory;
using formats::PointOutcome;

PointHistory Ended(PointOutcome outcome) {
  PointHistory mark;
  mark.outcome = outcome;
  mark.fired_count = formats::IsFired(outcome) ? 1 : 0;
  return mark;
}

PointHistory Open() {
  PointHistory mark;
  mark.open_intent = true;
  return mark;
}

PointHistory Reopened() {
  PointHistory mark;
  mark.reopened = true;
  return mark;
}

MarkComparison Burnt(std::vector<BurntFate> fates) {
  MarkComparison burnt;
  for (const BurntFate fate : fates) {
    burnt.marks.emplace_back();
    burnt.marks.back().fate = fate;
  }
  return burnt;
}

struct Case {
  const char* name;
  PointHistory journal;
  BurntFate burnt;
  MarkOutcome outcome;
  bool uncertain = false, unaccounted = false;
};

// Every state of the journal with every state of the material.
TEST(MarkAccount, JournalAndMaterialTogetherGiveOneOutcome) {
  const PointHistory made = Ended(PointOutcome::kMade),
                     skipped = Ended(PointOutcome::kSkipped),
                     left_out = Ended(PointOutcome::kLeftOut), none = PointHistory(),
                     uncertain = Ended(PointOutcome::kUncertain), open = Open(),
                     reopened = Reopened();
  const Case cases[] = {
      {"made", made, BurntFate::kMade, MarkOutcome::kMade},
      {"made, nothing burnt", made, BurntFate::kMissed, MarkOutcome::kMissed},
      {"made, half burnt", made, BurntFate::kIncomplete, MarkOutcome::kIncomplete},
      {"made, burnt twice", made, BurntFate::kDoubled, MarkOutcome::kDoubled},
      {"skipped", skipped, BurntFate::kMissed, MarkOutcome::kSkipped},
      {"left out", left_out, BurntFate::kMissed, MarkOutcome::kSkipped},
      {"never begun", none, BurntFate::kMissed, MarkOutcome::kSkipped},
      {"skipped and burnt", skipped, BurntFate::kMade, MarkOutcome::kMade, false, true},
      {"never begun, partly burnt", none, BurntFate::kIncomplete,
       MarkOutcome::kIncomplete, false, true},
      {"uncertain, burnt", uncertain, BurntFate::kMade, MarkOutcome::kMade, true},
      {"uncertain, partly", uncertain, BurntFate::kIncomplete, MarkOutcome::kIncomplete,
       true},
      {"uncertain, not burnt", uncertain, BurntFate::kMissed, MarkOutcome::kMissed, true},
      {"intent alone", open, BurntFate::kMade, MarkOutcome::kMade, true},
      {"reopened, not made again", reopened, BurntFate::kDoubled, MarkOutcome::kDoubled,
       true}};
  for (const Case& one : cases) {
    const auto account =
        AccountMarks(std::vector<PointHistory>{one.journal}, Burnt({one.burnt}));
    ASSERT_EQ(account.marks.size(), 1u);
    EXPECT_EQ(account.marks[0].outcome, one.outcome) << one.name;
    EXPECT_EQ(account.marks[0].uncertain, one.uncertain) << one.name;
    EXPECT_EQ(account.marks[0].unaccounted, one.unaccounted) << one.name;
    EXPECT_EQ(account.marks[0].is_right(),
              one.outcome == MarkOutcome::kMade && !one.uncertain && !one.unaccounted);
  }
}

TEST(MarkAccount, OutcomesAddUpToTheMarks) {
  const std::vector<PointHistory> history = {Ended(PointOutcome::kMade),
                                             Ended(PointOutcome::kUncertain),
                                             Open(),
                                             Ended(PointOutcome::kSkipped),
                                             PointHistory(),
                                             Ended(PointOutcome::kMade)};
  const auto account = AccountMarks(
      history, Burnt({BurntFate::kMade, BurntFate::kIncomplete, BurntFate::kMissed,
                      BurntFate::kMissed, BurntFate::kMade, BurntFate::kDoubled}));
  const MarkCount& count = account.count;
  EXPECT_EQ(count.made + count.skipped + count.missed + count.incomplete + count.doubled,
            history.size());
  EXPECT_EQ(count.made, 2u);
  EXPECT_EQ(count.skipped, 1u);
  EXPECT_EQ(account.uncertain_count, 2u);
  EXPECT_EQ(account.of_uncertain.incomplete, 1u);
  EXPECT_EQ(account.of_uncertain.missed, 1u);
  EXPECT_EQ(account.unaccounted_count, 1u);
}

TEST(MarkAccount, TheJournalAloneKnowsNoMoreThanItHas) {
  PointHistory twice = Ended(PointOutcome::kMade);
  twice.fired_count = 2;
  PointHistory again = Reopened();
  again.outcome = PointOutcome::kMade;
  again.fired_count = 1;
  const auto account = AccountMarks(
      std::vector<PointHistory>{Ended(PointOutcome::kMade), Ended(PointOutcome::kMissed),
                                Open(), twice, PointHistory(), again});
  EXPECT_EQ(account.count.made, 2u);
  EXPECT_EQ(account.count.missed, 1u);
  EXPECT_EQ(account.count.doubled, 1u);
  EXPECT_EQ(account.count.skipped, 1u);
  EXPECT_EQ(account.uncertain_count, 1u);
  EXPECT_EQ(account.marks[2].outcome, MarkOutcome::kUncertain);
}

TEST(MarkAccount, RefusesAJournalOfOtherMarks) {
  EXPECT_THROW(AccountMarks(std::vector<PointHistory>(2), Burnt({BurntFate::kMade})),
               PreconditionError);
}

}  // namespace
}  // namespace intaglio::proof
