#include "engrave/sort/beam/beam_cone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

TEST(BeamCone, OfPointsIsItsTangent) {
  const BeamCone cone = 0.25;
  EXPECT_DOUBLE_EQ(cone.ReachMm(4), 1);
  EXPECT_DOUBLE_EQ(cone.SteepestTangent(), 0.25);
  EXPECT_TRUE(cone.Shades(0.999, 4));
  EXPECT_FALSE(cone.Shades(1.001, 4));
}

TEST(BeamCone, WidensByTheCracksRadiusOverItsLength) {
  const BeamCone cone(0.25, 0.05, 0.2);
  EXPECT_DOUBLE_EQ(cone.ReachMm(0.1), 0.025 + 0.025);
  EXPECT_DOUBLE_EQ(cone.ReachMm(0.2), 0.05 + 0.05);
  EXPECT_DOUBLE_EQ(cone.ReachMm(10), 2.5 + 0.05);
  EXPECT_DOUBLE_EQ(cone.SteepestTangent(), 0.5);
}

TEST(BeamCone, ItsSurfaceAndWhatIsBesideOrBelowAreOutside) {
  for (const BeamCone& cone : {BeamCone(0.5), BeamCone(0.5, 0.1, 1)}) {
    EXPECT_FALSE(cone.Shades(cone.ReachMm(2), 2));
    EXPECT_FALSE(cone.Shades(cone.ReachMm(2) - 0.5e-9, 2)) << "rounding would decide";
    EXPECT_TRUE(cone.Shades(cone.ReachMm(2) - 2e-9, 2));
    EXPECT_FALSE(cone.Shades(0, 0));
    EXPECT_FALSE(cone.Shades(0, -1));
  }
  EXPECT_FALSE(BeamCone(0).Shades(0, 5)) << "no beam is without width";
}

// The properties that the searches by bounding boxes rely on: higher never reaches less
// far, the steepest tangent bounds it, and it is concave from 0, so that steps up add no
// less.
TEST(BeamCone, ReachGrowsWithinTheSteepestTangent) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const BeamCone cone(2 * unit(random), unit(random), 0.01 + unit(random));
    const double low_mm = 3 * unit(random);
    const double more_mm = 3 * unit(random);
    const double high_mm = low_mm + more_mm;
    ASSERT_GE(cone.ReachMm(high_mm), cone.ReachMm(low_mm));
    // A relative 1e-12 for the rounding of some operations.
    ASSERT_LE(cone.ReachMm(high_mm), cone.SteepestTangent() * high_mm * (1 + 1e-12));
    ASSERT_LE(cone.ReachMm(high_mm),
              (cone.ReachMm(low_mm) + cone.ReachMm(more_mm)) * (1 + 1e-12));
  }
}

TEST(BeamCone, WrongRangesThrow) {
  const double nan = std::nan("");
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_NO_THROW(RequireUsable({0, 0, 1}));
  EXPECT_NO_THROW(RequireUsable({1.5, 0.1, 0.3}));
  for (const double wrong : {-1e-9, nan, infinite}) {
    EXPECT_THROW(RequireUsable({wrong, 0, 1}), PreconditionError) << wrong;
    EXPECT_THROW(RequireUsable({0, wrong, 1}), PreconditionError) << wrong;
    EXPECT_THROW(RequireUsable({0, 0, wrong}), PreconditionError) << wrong;
  }
  EXPECT_THROW(RequireUsable({0, 0, 0}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
