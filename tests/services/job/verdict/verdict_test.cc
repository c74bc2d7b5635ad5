#include "services/job/verdict/verdict.h"

#include <gtest/gtest.h>

#include "services/platform/host/stage/counts_at_end.h"

namespace intaglio {
namespace {

intaglio_PointCounts Counts(std::uint64_t planned, std::uint64_t made) {
  intaglio_PointCounts counts{};
  counts.planned = planned;
  counts.made = made;
  return counts;
}

TEST(Verdict, GoodIsOnlyWhatIsWholeAndCertain) {
  intaglio_PointCounts counts = Counts(10, 10);
  EXPECT_EQ(VerdictOf(true, counts, {}).verdict, VerdictKind::kGood);
  EXPECT_EQ(VerdictOf(true, counts, {}).reason, "");
  counts = Counts(10, 9);
  counts.missed = 1;
  EXPECT_EQ(VerdictOf(true, counts, {}).verdict, VerdictKind::kNotGood);
  EXPECT_EQ(VerdictOf(true, counts, {}).reason, "of 10 points 1 missed");
  counts.missed = 0;
  EXPECT_EQ(VerdictOf(true, counts, {}).verdict, VerdictKind::kNotGood)
      << "a point is not accounted for";
  counts.skipped = 1;
  counts.uncertain = 2;
  EXPECT_EQ(VerdictOf(true, counts, {}).reason, "of 10 points 1 skipped, 2 uncertain");
}

TEST(Verdict, AWarningOfWeightIsAVerdictOfItsOwn) {
  intaglio_PointCounts counts = Counts(10, 10);
  const Warning note = MakeWarning(WarningCode::kOpenSurface, "open");
  const Warning rays = MakeWarning(WarningCode::kOddRays, "3 of 9 rays");
  const Warning glass = MakeWarning(WarningCode::kBreakage, "may break");
  EXPECT_EQ(VerdictOf(true, counts, {note}).verdict, VerdictKind::kGood);
  EXPECT_EQ(VerdictOf(true, counts, {note, rays}).verdict,
            VerdictKind::kGoodWithWarnings);
  EXPECT_EQ(VerdictOf(true, counts, {note, rays, glass}).reason,
            "may break; 3 of 9 rays");
  counts.made = 9;
  EXPECT_EQ(VerdictOf(true, counts, {rays}).verdict, VerdictKind::kNotGood);
  EXPECT_STREQ(VerdictName(VerdictKind::kGoodWithWarnings), "good_with_warnings");
}

TEST(Verdict, AJobThatDidNotEndLeavesASpoiledBlockOrAClearOne) {
  intaglio_PointCounts counts = Counts(10, 0);
  counts.skipped = 10;
  EXPECT_EQ(VerdictOf(false, counts, {}).verdict, VerdictKind::kNone);
  counts = Counts(10, 10);
  EXPECT_EQ(VerdictOf(false, counts, {}).verdict, VerdictKind::kNotGood)
      << "cancelled at the last point";
  EXPECT_EQ(VerdictOf(false, {}, {}).verdict, VerdictKind::kNone);
  EXPECT_EQ(VerdictOf(true, {}, {}).verdict, VerdictKind::kUnknown);
}

// A job that was cancelled, by the last that is known of it.
TEST(Verdict, AtTheEndWhatWasToComeIsSkippedAndWhatWasArmedUncertain) {
  intaglio_PointCounts counts = Counts(392, 229);
  counts.to_come = 160;
  counts.armed = 3;
  counts = AtEnd(counts);
  EXPECT_EQ(counts.to_come + counts.armed, 0u);
  const ShopVerdict verdict = VerdictOf(false, counts, {}, "marks");
  EXPECT_EQ(verdict.verdict, VerdictKind::kNotGood) << "cracks are in the glass";
  EXPECT_EQ(verdict.reason, "of 392 marks 160 skipped, 3 uncertain");
}

}  // namespace
}  // namespace intaglio
