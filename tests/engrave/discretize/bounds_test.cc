#include "engrave/discretize/bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Box3 kPermitted{Vec3(3, 3, 3), Vec3(97, 47, 27)};

PointCloud CloudOf(const PointList& points) {
  PointCloud cloud;
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
    const BoundsReport report = CheckBounds({p, Vec3(50, 25, 15)}, kPermitted);
    EXPECT_EQ(report.outside_count, 1u);
    for (std::size_t other = 0; other < 6; ++other) {
      EXPECT_EQ(report.side_count[other], other == side ? 1u : 0u);
      EXPECT_DOUBLE_EQ(report.side_excess_mm[other], other == side ? 0.5 : 0);
    }
  }
}

TEST(Bounds, APointBeyondACornerIsOnePointOnThreeSides) {
  const BoundsReport report = CheckBounds({Vec3(2, 48, 30)}, kPermitted);
  EXPECT_EQ(report.outside_count, 1u);
  EXPECT_EQ(report.side_count, (std::array<std::uint64_t, 6>{1, 0, 0, 1, 0, 1}));
  EXPECT_EQ(report.side_excess_mm, (std::array<double, 6>{1, 0, 0, 1, 0, 3}));
}

// A model fitted into the block touches the limits but for rounding.
TEST(Bounds, RoundingAtTheWallIsNotOutside) {
  const PointCloud cloud = CloudOf(
      {kPermitted.min_mm - Vec3::Constant(1e-12), kPermitted.max_mm * (1 + 1e-15)});
  const auto kept = KeepInside(cloud, kPermitted, false);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->points_mm, cloud.points_mm);
  EXPECT_FALSE(
      KeepInside(CloudOf({kPermitted.max_mm + Vec3(2e-6, 0, 0)}), kPermitted, false)
          .has_value());
}

TEST(Bounds, TheErrorTellsHowManyWhereAndByHowMuch) {
  const auto refused = KeepInside(
      CloudOf({Vec3(50, 25, 15), Vec3(98, 25, 15), Vec3(99.25, 25, 15), Vec3(50, 25, 1)}),
      kPermitted, false);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message, HasSubstr("3 of 4 points"));
  EXPECT_THAT(refused.error().message,
              HasSubstr("2 beyond the high x side by up to 2.250 mm"));
  EXPECT_THAT(refused.error().message,
              HasSubstr("1 beyond the low z side by up to 2.000 mm"));
  EXPECT_THAT(refused.error().message, Not(HasSubstr("high z")));
}

TEST(Bounds, ClipKeepsTheInsideInOrderWithItsSources) {
  const auto kept = KeepInside(
      CloudOf({Vec3(50, 25, 15), Vec3(98, 25, 15), Vec3(3, 3, 3), Vec3(50, 25, 1)}),
      kPermitted, true);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->points_mm, (PointList{Vec3(50, 25, 15), Vec3(3, 3, 3)}));
  EXPECT_EQ(kept->source, (std::vector<std::uint32_t>{0, 2}));
}

}  // namespace
}  // namespace intaglio::discretize
