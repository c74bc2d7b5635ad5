#include "engrave/discretize/spacing/bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Box3 kPermitted{Vec3(3, 3, 3), Vec3(97, 47, 27)};

SpacedCloud CloudOf(const PointList& points) {
  SpacedCloud cloud;
  std::uint32_t source = 0;
  for (const Vec3& p : points) cloud.Add(p, source++);
  return cloud;
}

TEST(Bounds, EachOfTheSixWallsIsCounted) {
  for (std::size_t side = 0; side < 6; ++side) {
    const auto axis = static_cast<Eigen::Index>(side / 2);
    Vec3 p(50, 25, 15);
    p[axis] =
        side % 2 == 0 ? kPermitted.min_mm[axis] - 0.5 : kPermitted.max_mm[axis] + 0.5;
    SpacedCloud cloud = CloudOf({p, Vec3(50, 25, 15)});
    const BoundsReport report = TakeOutside(kPermitted, cloud);
    EXPECT_EQ(cloud.size(), 1u);
    EXPECT_EQ(report.outside_count, 1u);
    for (std::size_t other = 0; other < 6; ++other) {
      EXPECT_EQ(report.side_count[other], other == side ? 1u : 0u);
      EXPECT_DOUBLE_EQ(report.side_excess_mm[other], other == side ? 0.5 : 0);
    }
  }
}

TEST(Bounds, APointBeyondACornerIsOnePointOnThreeSides) {
  SpacedCloud cloud = CloudOf({Vec3(2, 48, 30)});
  const BoundsReport report = TakeOutside(kPermitted, cloud);
  EXPECT_EQ(report.outside_count, 1u);
  EXPECT_EQ(report.side_count, (std::array<std::uint64_t, 6>{1, 0, 0, 1, 0, 1}));
  EXPECT_EQ(report.side_excess_mm, (std::array<double, 6>{1, 0, 0, 1, 0, 3}));
}

// A model fitted into the block touches the limits but for rounding.
TEST(Bounds, RoundingAtTheWallIsNotOutside) {
  SpacedCloud cloud = CloudOf(
      {kPermitted.min_mm - Vec3::Constant(1e-12), kPermitted.max_mm * (1 + 1e-15)});
  EXPECT_EQ(TakeOutside(kPermitted, cloud).outside_count, 0u);
  EXPECT_EQ(cloud.size(), 2u);
  SpacedCloud beyond = CloudOf({kPermitted.max_mm + Vec3(2e-6, 0, 0)});
  EXPECT_EQ(TakeOutside(kPermitted, beyond).outside_count, 1u);
}

TEST(Bounds, TheErrorReportsHowManyWhereAndByHowMuch) {
  SpacedCloud cloud =
      CloudOf({Vec3(50, 25, 15), Vec3(98, 25, 15), Vec3(99.25, 25, 15), Vec3(50, 25, 1)});
  const Error error = OutsideBlock(TakeOutside(kPermitted, cloud), 4);
  EXPECT_EQ(error.code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(error.message, HasSubstr("3 of 4 points"));
  EXPECT_THAT(error.message, HasSubstr("2 beyond the high x side by up to 2.250 mm"));
  EXPECT_THAT(error.message, HasSubstr("1 beyond the low z side by up to 2.000 mm"));
  EXPECT_THAT(error.message, Not(HasSubstr("high z")));
}

TEST(Bounds, ReportsOfPartsAddUp) {
  SpacedCloud first = CloudOf({Vec3(98, 25, 15), Vec3(50, 25, 15)});
  SpacedCloud second = CloudOf({Vec3(99, 25, 1)});
  BoundsReport both = TakeOutside(kPermitted, first);
  both.Add(TakeOutside(kPermitted, second));
  EXPECT_EQ(both.outside_count, 2u);
  EXPECT_EQ(both.side_count, (std::array<std::uint64_t, 6>{0, 2, 0, 0, 1, 0}));
  EXPECT_EQ(both.side_excess_mm, (std::array<double, 6>{0, 2, 0, 0, 2, 0}));
}

TEST(Bounds, TheInsideStaysInOrderWithItsSources) {
  SpacedCloud cloud =
      CloudOf({Vec3(50, 25, 15), Vec3(98, 25, 15), Vec3(3, 3, 3), Vec3(50, 25, 1)});
  TakeOutside(kPermitted, cloud);
  EXPECT_EQ(cloud.points_mm, (PointList{Vec3(50, 25, 15), Vec3(3, 3, 3)}));
  EXPECT_EQ(cloud.source, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(cloud.spacing_mm.size(), 2u);
}

}  // namespace
}  // namespace intaglio::discretize
