#include "engrave/render/deviations.h"

#include <gtest/gtest.h>

namespace intaglio::render {
namespace {

bool IsLongestColour(const Color& color) { return color.r > 0.5F && color.g < 0.25F; }

/// Extent of what is red above the legend, pixels.
Box3 RedOf(const Canvas& canvas, int from_px, int to_px) {
  Box3 box;
  for (int y = 80; y < 960; ++y)
    for (int x = from_px; x < to_px; ++x)
      if (IsLongestColour(canvas.at(x, y))) box.Extend(Vec3(x, y, 0));
  return box;
}

TEST(Deviations, TheLongestArrowIsRedAndAsLongAsItsMagnification) {
  // 100 mm are 780 pixels wide.
  const std::vector<Deviation> deviations = {{{0, 0}, {0.001, 0}},
                                             {{100, 0}, {0, 0}},
                                             {{0, 100}, {0, 0}},
                                             {{50, 50}, {0.01, 0}}};
  const Canvas canvas = DrawDeviations({{"panel", deviations}}, {"sigma    5 um"});
  const Box3 red = RedOf(canvas, 0, 900);
  const double long_px = MagnificationOf(deviations) * 0.01 * 7.8;
  EXPECT_GT(long_px, 20);
  // From its place to the disc at its end, 3.5 pixels around it.
  EXPECT_NEAR(red.size_mm().x(), long_px + 3.5, 3);
  EXPECT_NEAR(red.center_mm().x(), 60 + 390 + red.size_mm().x() / 2, 3);
}

TEST(Deviations, EachPanelHasAScaleOfItsOwn) {
  const std::vector<Deviation> large = {{{0, 0}, {2, 0}}, {{50, 50}, {0, 2}}};
  const std::vector<Deviation> small = {{{0, 0}, {0.002, 0}}, {{50, 50}, {0, 0.002}}};
  const Canvas canvas = DrawDeviations({{"before", large}, {"after", small}}, {});
  ASSERT_GE(canvas.width(), 1800);
  EXPECT_NEAR(RedOf(canvas, 0, 900).size_mm().x(), RedOf(canvas, 900, 1800).size_mm().x(),
              2);
  EXPECT_NEAR(MagnificationOf(small) / MagnificationOf(large), 1000, 1e-6);
}

TEST(Deviations, NothingMeasuredIsAPictureToo) {
  EXPECT_GT(DrawDeviations({{"nothing", {}}}, {"a line"}).height(), 900);
  EXPECT_GT(DrawDeviations({{"one", {{{5, 5}, {0, 0}}}}}, {}).height(), 900);
}

}  // namespace
}  // namespace intaglio::render
