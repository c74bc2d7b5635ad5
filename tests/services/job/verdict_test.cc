#include "services/job/verdict.h"

#include <gtest/gtest.h>

namespace intaglio {
namespace {

EngraveOutcome Outcome(std::uint64_t planned, std::uint64_t made) {
  EngraveOutcome outcome;
  outcome.set_planned_count(planned);
  outcome.set_made_count(made);
  return outcome;
}

TEST(Verdict, GoodIsOnlyWhatIsWholeAndCertain) {
  EngraveOutcome outcome = Outcome(10, 10);
  EXPECT_EQ(VerdictOf(true, &outcome).word, "good");
  EXPECT_EQ(VerdictOf(true, &outcome).reason, "");
  outcome = Outcome(10, 9);
  outcome.set_missed_count(1);
  EXPECT_EQ(VerdictOf(true, &outcome).word, "not_good");
  EXPECT_EQ(VerdictOf(true, &outcome).reason, "of 10 points 1 missed");
  outcome.set_missed_count(0);
  EXPECT_EQ(VerdictOf(true, &outcome).word, "not_good") << "a point is not accounted for";
  outcome.set_skipped_count(1);
  outcome.set_uncertain_count(2);
  EXPECT_EQ(VerdictOf(true, &outcome).reason, "of 10 points 1 skipped, 2 uncertain");
}

TEST(Verdict, AJobThatDidNotEndLeavesASpoiledBlockOrAClearOne) {
  EngraveOutcome outcome = Outcome(10, 0);
  outcome.set_skipped_count(10);
  EXPECT_EQ(VerdictOf(false, &outcome).word, "none");
  outcome = Outcome(10, 10);
  EXPECT_EQ(VerdictOf(false, &outcome).word, "not_good") << "cancelled at the last point";
  EXPECT_EQ(VerdictOf(false, nullptr).word, "none");
  EXPECT_EQ(VerdictOf(true, nullptr).word, "unknown");
}

}  // namespace
}  // namespace intaglio
