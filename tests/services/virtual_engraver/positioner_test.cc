#include "services/virtual_engraver/positioner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "tests/services/virtual_engraver/positioner_text.h"

namespace intaglio::virtual_engraver {
namespace {

using std::numbers::pi;

TEST(Positioner, WithoutANameTheHeadGoesWhereTheAxesState) {
  const Vec3 axes(0.1, -7, 1e-9);
  EXPECT_EQ(FocusAt(PositionerOf(""), axes), axes);
  EXPECT_EQ(FocusAt(PositionerOf("head,head,head"), axes), axes);
}

// A block that goes right is hit farther left.
TEST(Positioner, ABlockOnTheCarriageIsHitTheOtherWay) {
  EXPECT_EQ(FocusAt(PositionerOf("block,block,head"), Vec3(1, 2, 3)), Vec3(-1, -2, 3));
  EXPECT_EQ(FocusAt(PositionerOf("-block,head,-head"), Vec3(1, 2, 3)), Vec3(1, 2, -3));
}

TEST(Positioner, AnArmSweepsACircleAndTheTableTurnsTheBlockBelow) {
  const PositionerOptions arm = PositionerOf("arm,200,150,head");
  EXPECT_LT((FocusAt(arm, Vec3(0, 0, 4)) - Vec3(0, 50, 4)).norm(), 1e-12);
  // A quarter counterclockwise from -y is +x.
  EXPECT_LT((FocusAt(arm, Vec3(pi / 2, 0, 0)) - Vec3(150, 200, 0)).norm(), 1e-12);
  // The table turned a quarter counterclockwise brings what was at +x under +y.
  EXPECT_LT((FocusAt(arm, Vec3(0, pi / 2, 0)) - Vec3(50, 0, 0)).norm(), 1e-12);
  EXPECT_LT((FocusAt(PositionerOf("arm,200,150,block"), Vec3(0, 0, 4)) - Vec3(0, 50, -4))
                .norm(),
            1e-12);
}

// Nodes at -10, 0 and 10 mm: between four of them by the areas, beyond them as at the
// border, and on top of the command before the guides turn and stretch it.
TEST(Positioner, DeviationsOfTheFieldAreAddedToTheCommand) {
  PositionerOptions mirrors;
  mirrors.has_mirrors = true;
  mirrors.guides[0].travel_ratio = 2;
  mirrors.deviations = {10, 3, std::vector<Vec2>(9, Vec2::Zero())};
  mirrors.deviations.values_mm[4] = {0.4, -0.8};  // the middle
  mirrors.deviations.values_mm[8] = {1, 2};       // at (10, 10)
  const auto at = [&](double x, double y) {
    return Vec2(FocusAt(mirrors, {x, y, 0}).head<2>());
  };
  EXPECT_LT((at(0, 0) - Vec2(0.8, -0.8)).norm(), 1e-12);
  EXPECT_LT(
      (at(5, 2.5) - Vec2(2 * (5 + 0.375 * 0.4 + 0.125), 2.5 - 0.375 * 0.8 + 0.25)).norm(),
      1e-12);
  EXPECT_LT((at(-10, 10) - Vec2(-20, 10)).norm(), 1e-12);
  EXPECT_LT((at(15, 30) - Vec2(32, 32)).norm(), 1e-12);
  EXPECT_EQ(BeamSlopes(mirrors, {10, 10, 0}), Vec2(22, 12) / 1e6);
}

TEST(Positioner, FocusPerUnitIsTheLargestOverTheBlock) {
  const Box3 block{Vec3(-25, 80, 0), Vec3(25, 130, 30)};
  EXPECT_EQ(FocusPerAxisUnitMm(PositionerOf("block,head,head"), block), Vec3(1, 1, 1));
  const PositionerOptions arm = PositionerOf("arm,200,150,head");
  const Vec3 per_unit_mm = FocusPerAxisUnitMm(arm, block);
  EXPECT_EQ(per_unit_mm.x(), 150);
  // A turn of 1 urad of the table moves the farthest corner, (25, 130), by that much.
  const Vec3 axes(5.5, 0.3, 0), turned = axes + Vec3(0, 1e-6, 0);
  const Vec3 at_mm = FocusAt(arm, axes);
  const double moved_mm = (FocusAt(arm, turned) - at_mm).norm() / 1e-6;
  EXPECT_NEAR(moved_mm, at_mm.head<2>().norm(), 1e-6);
  EXPECT_NEAR(per_unit_mm.y(), std::hypot(25, 130), 1e-12);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
