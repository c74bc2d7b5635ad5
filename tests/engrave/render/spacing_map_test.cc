#include "engrave/render/spacing_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engrave/core/check.h"

namespace intaglio::render {
namespace {

/// A sheet of points in the plane y = 5, 0.2 mm apart.
PointList Sheet() {
  PointList points;
  for (int i = 0; i < 50; ++i) {
    for (int k = 0; k < 50; ++k) points.emplace_back(0.2 * i, 5, 0.2 * k);
  }
  return points;
}

struct Measured {
  PointList points_mm;
  std::vector<double> nearest_mm;
  std::vector<std::uint64_t> bins = std::vector<std::uint64_t>(60, 1);

  Canvas Render() const {
    return RenderSpacingMap({points_mm, nearest_mm, 0.2, 0.01, bins}, {});
  }
};

Measured EvenSheet() {
  Measured even{Sheet(), {}};
  even.nearest_mm.assign(even.points_mm.size(), 0.2);
  return even;
}

bool IsRed(const Color& c) { return c.r > 0.25F && c.r > 3 * c.g && c.r > 3 * c.b; }
bool IsGreen(const Color& c) { return c.g > 0.2F && c.g > 1.5F * c.r; }

/// Pixels of the front view, the large cell, for which `is` holds.
template <typename Is>
int CountInFront(const Canvas& canvas, Is is) {
  int count = 0;
  for (int y = 110; y < 1176; ++y) {
    for (int x = 24; x < 1053; ++x) count += is(canvas.at(x, y));
  }
  return count;
}

TEST(SpacingColor, GoesFromRedOverGreenToBlue) {
  EXPECT_TRUE(IsRed(SpacingColor(0.99)));
  EXPECT_TRUE(IsGreen(SpacingColor(1.0)));
  EXPECT_TRUE(IsGreen(SpacingColor(1 - 1e-12)));
  for (const double wide : {2.5, 40.0, std::numeric_limits<double>::infinity()}) {
    const Color c = SpacingColor(wide);
    EXPECT_GT(c.b, 3 * c.g);
  }
}

TEST(SpacingMap, AnEvenSheetIsGreenAndFillsTheFront) {
  const Canvas canvas = EvenSheet().Render();
  EXPECT_EQ(canvas.width(), kViewsWidth);
  EXPECT_EQ(canvas.height(), kViewsHeight);
  // The sheet is as wide as the cell but for its margins, and as high.
  EXPECT_GT(CountInFront(canvas, IsGreen), 250000);
  EXPECT_EQ(CountInFront(canvas, IsRed), 0);
}

TEST(SpacingMap, TooNearShowsThroughWhatHidesIt) {
  Measured hidden = EvenSheet();
  hidden.points_mm.emplace_back(5, 9, 5);  // behind the sheet
  hidden.nearest_mm.push_back(0.05);
  const Canvas behind = hidden.Render();
  Measured shown = EvenSheet();
  shown.points_mm.emplace_back(5, 1, 5);
  shown.nearest_mm.push_back(0.05);
  const Canvas before = shown.Render();
  const auto reddish = [](const Color& c) { return c.r > 0.15F && c.r > 1.2F * c.b; };
  EXPECT_GT(CountInFront(behind, reddish), CountInFront(EvenSheet().Render(), reddish));
  EXPECT_GT(CountInFront(before, IsRed), 20);
}

TEST(SpacingMap, DrawsAloneAndFlatAndTheSameTwice) {
  Measured alone{{Vec3(3, 3, 3)}, {std::numeric_limits<double>::infinity()}};
  const Canvas once = alone.Render(), twice = alone.Render();
  for (int y = 0; y < once.height(); y += 7) {
    for (int x = 0; x < once.width(); x += 7) {
      ASSERT_EQ(once.at(x, y).b, twice.at(x, y).b);
    }
  }
  EXPECT_THROW(Measured().Render(), PreconditionError);
}

}  // namespace
}  // namespace intaglio::render
