#include "engrave/render/projection.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(Projection, StepsAreRound) {
  EXPECT_DOUBLE_EQ(NiceStep(80, 8), 10.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 7), 20.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 3), 50.0);
  EXPECT_DOUBLE_EQ(NiceStep(80, 1), 100.0);
  EXPECT_DOUBLE_EQ(NiceStep(0.9, 5), 0.2);
}

}  // namespace
}  // namespace intaglio::render
