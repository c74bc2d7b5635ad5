#include "engrave/render/projection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace intaglio::render {
namespace {

TEST(Projection, ParallelKeepsScaleAndSense) {
  const auto front = Projection::Parallel(Vec3::UnitX(), Vec3::UnitZ(), Vec3(30, 30, 40),
                                          Vec2(100, 200), 5.0);
  const Projected seen = front(Vec3(32, 20, 41));
  EXPECT_NEAR(seen.at_px.x(), 110.0, 1e-12);
  EXPECT_NEAR(seen.at_px.y(), 195.0, 1e-12);  // up in the block is up in the picture
  EXPECT_NEAR(seen.depth_mm, -10.0, 1e-12);   // seen from -y: smaller y is nearer
  EXPECT_EQ(front.px_per_mm(3.0), 5.0);
  EXPECT_TRUE(front.Sees(-Vec3::UnitY(), Vec3::Zero()));
  EXPECT_FALSE(front.Sees(Vec3::UnitZ(), Vec3::Zero()));
}

TEST(Projection, FromAboveTheHigherPointIsNearer) {
  const auto above =
      Projection::Parallel(Vec3::UnitX(), Vec3::UnitY(), Vec3::Zero(), Vec2(0, 0), 1.0);
  EXPECT_LT(above(Vec3(0, 0, 5)).depth_mm, above(Vec3(0, 0, 1)).depth_mm);
}

TEST(Projection, FromTheRightTheFrontIsAtTheLeft) {
  const auto right =
      Projection::Parallel(Vec3::UnitY(), Vec3::UnitZ(), Vec3::Zero(), Vec2(0, 0), 1.0);
  EXPECT_LT(right(Vec3(0, 1, 0)).at_px.x(), right(Vec3(0, 5, 0)).at_px.x());
  EXPECT_LT(right(Vec3(9, 0, 0)).depth_mm, right(Vec3(1, 0, 0)).depth_mm);
}

TEST(Projection, PerspectiveFillsItsRectangle) {
  const Rect into{50, 40, 600, 400};
  for (const Vec3& size : {Vec3(60, 60, 80), Vec3(200, 20, 30), Vec3(10, 90, 10)}) {
    const auto view = Projection::Perspective({Vec3::Zero(), size}, 0.5, 0.3, into);
    Vec2 low(1e9, 1e9);
    Vec2 high = -low;
    for (const Vec3& corner : CornersOf({Vec3::Zero(), size})) {
      const Vec2 at = view(corner).at_px;
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
    // One of the two directions is filled, both are centred.
    const Vec2 span = high - low;
    EXPECT_NEAR(std::max(span.x() / 600.0, span.y() / 400.0), 1.0, 1e-9);
    EXPECT_NEAR(0.5 * (low.x() + high.x()), 350.0, 1e-9);
    EXPECT_NEAR(0.5 * (low.y() + high.y()), 240.0, 1e-9);
  }
}

TEST(Projection, PerspectiveShowsFrontRightAndTop) {
  const Vec3 size(60, 60, 80);
  const auto view =
      Projection::Perspective({Vec3::Zero(), size}, 0.5, 0.3, {0, 0, 500, 500});
  EXPECT_TRUE(view.Sees(-Vec3::UnitY(), Vec3::Zero()));
  EXPECT_TRUE(view.Sees(Vec3::UnitX(), size));
  EXPECT_TRUE(view.Sees(Vec3::UnitZ(), size));
  EXPECT_FALSE(view.Sees(Vec3::UnitY(), size));
  // The farther, the smaller.
  const double near = view(Vec3(30, 0, 40)).depth_mm;
  const double far = view(Vec3(30, 60, 40)).depth_mm;
  EXPECT_LT(near, far);
  EXPECT_GT(view.px_per_mm(near), view.px_per_mm(far));
}

TEST(Projection, ARollTurnsThePictureCounterclockwiseAndChangesNothingElse) {
  const Box3 box{Vec3::Zero(), Vec3(60, 40, 80)};
  const Rect into{0, 0, 500, 500};
  const double roll_rad = 0.7;
  for (const auto make : {Projection::Perspective, Projection::ParallelView}) {
    const Projection straight = make(box, 0.5, 0.3, into, 0);
    const Projection rolled = make(box, 0.5, 0.3, into, roll_rad);
    const Vec3 middle = box.center_mm();
    const auto from_middle = [&](const Projection& view, const Vec3& place) {
      return Vec2((view(place).at_px - view(middle).at_px) /
                  view.px_per_mm(view(middle).depth_mm));
    };
    for (const Vec3& place : CornersOf(box)) {
      EXPECT_NEAR(rolled(place).depth_mm, straight(place).depth_mm, 1e-9);
      // y is down in a picture: counterclockwise is (x c + y s, y c - x s).
      const Vec2 at = from_middle(straight, place);
      const Vec2 turned(at.x() * std::cos(roll_rad) + at.y() * std::sin(roll_rad),
                        at.y() * std::cos(roll_rad) - at.x() * std::sin(roll_rad));
      EXPECT_TRUE(from_middle(rolled, place).isApprox(turned, 1e-9)) << at.transpose();
    }
    // What was up points to the left now.
    EXPECT_TRUE(straight.PictureDirection(Vec3::UnitZ()).isApprox(Vec2(0, -1), 1e-12));
    EXPECT_TRUE(make(box, 0.5, 0.3, into, std::numbers::pi / 2)
                    .PictureDirection(Vec3::UnitZ())
                    .isApprox(Vec2(-1, 0), 1e-12));
  }
}

TEST(Projection, StepsAreRound) {
  EXPECT_DOUBLE_EQ(NiceStep(80, 8), 10.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 7), 20.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 3), 50.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 1), 100.0);
  EXPECT_DOUBLE_EQ(NiceStep(0.9, 5), 0.2);
}

TEST(Projection, IsometricViewShortensAllAxesAlike) {
  const Box3 box{Vec3::Zero(), Vec3(60, 40, 80)};
  const Rect into{100, 50, 900, 700};
  const Projection view = Projection::ParallelView(box, std::numbers::pi / 4,
                                                   std::asin(1 / std::sqrt(3.0)), into);
  const Vec2 origin = view(Vec3::Zero()).at_px;
  const double x = (view(Vec3(10, 0, 0)).at_px - origin).norm();
  // By definition: the same length along each axis, 120 degrees apart, z straight up.
  EXPECT_NEAR((view(Vec3(0, 10, 0)).at_px - origin).norm(), x, 1e-9);
  EXPECT_NEAR((view(Vec3(0, 0, 10)).at_px - origin).norm(), x, 1e-9);
  const Vec2 up = view(Vec3(0, 0, 10)).at_px - origin;
  EXPECT_NEAR(up.x(), 0, 1e-9);
  EXPECT_LT(up.y(), 0);
  const Vec2 along = view(Vec3(10, 0, 0)).at_px - origin;
  EXPECT_NEAR(along.dot(up) / (x * x), -0.5, 1e-9);
  // Parallel lines stay parallel, and the block fills the room on one of both ways.
  EXPECT_TRUE(
      (view(Vec3(10, 40, 80)).at_px - view(Vec3(0, 40, 80)).at_px).isApprox(along, 1e-9));
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const Vec3& corner : CornersOf(box)) {
    const Vec2 at = view(corner).at_px;
    left = std::min(left, at.x()), right = std::max(right, at.x());
    top = std::min(top, at.y()), bottom = std::max(bottom, at.y());
  }
  EXPECT_GE(left, 100 - 1e-9);
  EXPECT_LE(right, 1000 + 1e-9);
  EXPECT_GE(top, 50 - 1e-9);
  EXPECT_LE(bottom, 750 + 1e-9);
  EXPECT_NEAR(std::max((right - left) / 900, (bottom - top) / 700), 1, 1e-9);
}

}  // namespace
}  // namespace intaglio::render
