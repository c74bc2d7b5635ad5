#include "services/virtual_engraver/beam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engrave/optics/focus.h"

// A ray that heads for the axis with the angle a from it meets the top face at the
// distance r = d tan(a) from the axis, d being how far its meeting point in air lies
// under the face. Inside it goes on with sin(g) = sin(a) / n and reaches the axis at the
// depth z = r / tan(g) = d tan(a) / tan(g): deeper than d, as n > 1.

namespace intaglio::virtual_engraver {
namespace {

BlockInMachine Block(double refractive_index, double numerical_aperture) {
  return {Vec3(10, 20, 5), Vec3(80, 60, 40), refractive_index, numerical_aperture};
}

double DepthByAngles(double depth_in_air_mm, double n, double na) {
  const double air_rad = std::asin(na), glass_rad = std::asin(na / n);
  return depth_in_air_mm * std::tan(air_rad) / std::tan(glass_rad);
}

TEST(Beam, MeetsWhereSnellsLawStates) {
  for (double n = 1.4; n < 1.95; n += 0.1) {
    for (double na = 0.02; na < 0.31; na += 0.04) {
      const BlockInMachine block = Block(n, na);
      const double top_mm = block.origin_mm.z() + block.size_mm.z();
      for (const double depth_in_air_mm : {0.001, 1.0, 7.5, 19.0}) {
        const Focus focus = TraceFocus({33.3, 44.4, top_mm - depth_in_air_mm}, block);
        const double depth_mm = block.size_mm.z() - focus.position_mm.z();
        EXPECT_NEAR(depth_mm, DepthByAngles(depth_in_air_mm, n, na), 1e-10)
            << n << " " << na;
        EXPECT_GT(depth_mm, n * depth_in_air_mm) << "sign: glass makes it deeper";
        EXPECT_NEAR(focus.position_mm.x(), 23.3, 1e-10);
        EXPECT_NEAR(focus.position_mm.y(), 24.4, 1e-10);
        EXPECT_TRUE(focus.in_glass);
      }
    }
  }
}

// The planner's correction goes the other way by a formula of its own; both have to
// agree, or the cracks come out at the wrong depth.
TEST(Beam, IsTheInverseOfThePlannersCorrection) {
  for (const double n : {1.4, 1.52, 1.9}) {
    for (const double na : {0.02, 0.124, 0.3}) {
      const BlockInMachine block = Block(n, na);
      const double top_mm = block.origin_mm.z() + block.size_mm.z();
      for (const double depth_mm : {0.5, 12.0, 39.5}) {
        const double travel_mm = depth_mm * optics::StagePerGlassRatio(n, na);
        const Focus focus = TraceFocus({50, 50, top_mm - travel_mm}, block);
        EXPECT_NEAR(block.size_mm.z() - focus.position_mm.z(), depth_mm, 1e-9);
      }
    }
  }
}

TEST(Beam, WithoutRefractionItIsWhereTheStageIs) {
  const Vec3 stage_mm(40, 50, 17);
  const Vec3 expected = stage_mm - Block(1, 0.2).origin_mm;
  EXPECT_LT((TraceFocus(stage_mm, Block(1, 0.2)).position_mm - expected).norm(), 1e-10);
}

TEST(Beam, OnTheFaceNothingIsRefracted) {
  const BlockInMachine block = Block(1.5, 0.2);
  const Focus focus = TraceFocus({40, 50, 45}, block);
  EXPECT_LT((focus.position_mm - Vec3(30, 30, 40)).norm(), 1e-12);
  EXPECT_TRUE(focus.in_glass);
}

TEST(Beam, ReportsWhatLiesBesideTheBlock) {
  const BlockInMachine block = Block(1.5, 0.1);
  EXPECT_FALSE(TraceFocus({40, 50, 45.001}, block).in_glass) << "above";
  EXPECT_FALSE(TraceFocus({9.99, 50, 40}, block).in_glass);
  EXPECT_FALSE(TraceFocus({40, 80.01, 40}, block).in_glass);
  // 30 mm of travel is more than 45 mm deep: through the bottom of a 40 mm block.
  EXPECT_FALSE(TraceFocus({40, 50, 15}, block).in_glass);
  EXPECT_TRUE(TraceFocus({40, 50, 19}, block).in_glass);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
