#include "services/client/proof/proof_verdict.h"

#include <gtest/gtest.h>

#include "services/client/proof/evidence/verdict_text.h"

namespace intaglio::client {
namespace {

/// The report of a job whose points were all made where they are planned.
JobReport Made(std::uint64_t count) {
  JobReport report;
  report.set_min_spacing_mm(0.1);
  report.set_measured_spacing_mm(count > 1 ? 0.1 : 0);
  report.mutable_points()->set_planned(count);
  report.mutable_points()->set_made(count);
  report.mutable_position_errors()->set_tolerance_um(30);
  return report;
}

VerdictKind ByCounts(std::uint64_t planned, std::uint64_t made) {
  intaglio_PointCounts counts{};
  counts.planned = static_cast<std::uint32_t>(planned);
  counts.made = static_cast<std::uint32_t>(made);
  counts.missed = counts.planned - counts.made;
  return VerdictOf(true, counts, {}).verdict;
}

// The report of a job and the list of the shop: a test pulse is one point.
TEST(ProofVerdict, OfAFewPointsIsThatOfTheList) {
  for (const std::uint64_t count : {1, 2, 3}) {
    JobReport report = Made(count);
    Judge(report);
    EXPECT_EQ(KindOf(report.verdict()), VerdictKind::kGood) << count;
    EXPECT_EQ(ByCounts(count, count), VerdictKind::kGood);
    report.mutable_points()->set_made(count - 1);
    report.mutable_points()->set_missed(1);
    Judge(report);
    EXPECT_EQ(KindOf(report.verdict()), VerdictKind::kNotGood) << count;
    EXPECT_EQ(ByCounts(count, count - 1), VerdictKind::kNotGood);
  }
}

TEST(ProofVerdict, OnePointHasNoSpacing) {
  EXPECT_EQ(SpacingText(Made(1)), "none: one point");
  EXPECT_EQ(SpacingText(Made(2)), "0.1000 mm");
  JobReport near = Made(2);
  near.set_measured_spacing_mm(0.05);
  Judge(near);
  EXPECT_EQ(KindOf(near.verdict()), VerdictKind::kNotGood);
}

}  // namespace
}  // namespace intaglio::client
