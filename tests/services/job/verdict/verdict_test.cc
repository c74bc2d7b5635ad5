#include "services/job/verdict/verdict.h"

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
  EXPECT_EQ(VerdictOf(true, &outcome, {}).verdict, VerdictKind::kGood);
  EXPECT_EQ(VerdictOf(true, &outcome, {}).reason, "");
  outcome = Outcome(10, 9);
  outcome.set_missed_count(1);
  EXPECT_EQ(VerdictOf(true, &outcome, {}).verdict, VerdictKind::kNotGood);
  EXPECT_EQ(VerdictOf(true, &outcome, {}).reason, "of 10 points 1 missed");
  outcome.set_missed_count(0);
  EXPECT_EQ(VerdictOf(true, &outcome, {}).verdict, VerdictKind::kNotGood)
      << "a point is not accounted for";
  outcome.set_skipped_count(1);
  outcome.set_uncertain_count(2);
  EXPECT_EQ(VerdictOf(true, &outcome, {}).reason, "of 10 points 1 skipped, 2 uncertain");
}

TEST(Verdict, AWarningOfWeightIsAVerdictOfItsOwn) {
  EngraveOutcome outcome = Outcome(10, 10);
  const Warning note = MakeWarning(WarningCode::kOpenSurface, "open");
  const Warning rays = MakeWarning(WarningCode::kOddRays, "3 of 9 rays");
  const Warning glass = MakeWarning(WarningCode::kBreakage, "may break");
  EXPECT_EQ(VerdictOf(true, &outcome, {note}).verdict, VerdictKind::kGood);
  EXPECT_EQ(VerdictOf(true, &outcome, {note, rays}).verdict,
            VerdictKind::kGoodWithWarnings);
  EXPECT_EQ(VerdictOf(true, &outcome, {note, rays, glass}).reason,
            "may break; 3 of 9 rays");
  outcome.set_made_count(9);
  EXPECT_EQ(VerdictOf(true, &outcome, {rays}).verdict, VerdictKind::kNotGood);
  EXPECT_STREQ(VerdictName(VerdictKind::kGoodWithWarnings), "good_with_warnings");
}

TEST(Verdict, AJobThatDidNotEndLeavesASpoiledBlockOrAClearOne) {
  EngraveOutcome outcome = Outcome(10, 0);
  outcome.set_skipped_count(10);
  EXPECT_EQ(VerdictOf(false, &outcome, {}).verdict, VerdictKind::kNone);
  outcome = Outcome(10, 10);
  EXPECT_EQ(VerdictOf(false, &outcome, {}).verdict, VerdictKind::kNotGood)
      << "cancelled at the last point";
  EXPECT_EQ(VerdictOf(false, nullptr, {}).verdict, VerdictKind::kNone);
  EXPECT_EQ(VerdictOf(true, nullptr, {}).verdict, VerdictKind::kUnknown);
}

}  // namespace
}  // namespace intaglio
