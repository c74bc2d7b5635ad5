#include "engrave/contour/milling/material_use.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Edges Plate(const Vec2& a, const Vec2& sides) {
  const Vec2 b = a + sides;
  return {MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
          MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)};
}

// The published example: nine parts on a sheet of 600 x 400 mm use 60.24 %. Its drawing
// is not published; nine plates of 180 x 100 with a square hole of 44 have the same area,
// 144 576 mm2.
TEST(MaterialUse, OfThePublishedExample) {
  std::vector<Edges> loops;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      const Vec2 at(10 + 195 * x, 20 + 125 * y);
      loops.push_back(Plate(at + Vec2(60, 30), {44, 44}));
      loops.push_back(Plate(at, {180, 100}));
    }
  }
  loops.push_back(Plate({0, 0}, {600, 400}));
  const auto use = MaterialUseOf(loops);
  ASSERT_TRUE(use) << use.error().message;
  EXPECT_NEAR(use->use_percent, 60.24, 1e-9);
  EXPECT_NEAR(use->used_mm2, 144'576, 1e-6);
  EXPECT_EQ(use->part_count, 9U);
  EXPECT_EQ(use->hole_count, 9U);
}

TEST(MaterialUse, OfArcsIsExactAndPartsInHolesCount) {
  const auto circle = [](const Vec2& c, double r) {
    return Edges{MakeArc(c, r, 0, 2 * pi)};
  };
  const auto use = MaterialUseOf({Plate({0, 0}, {100, 100}), circle({50, 50}, 40),
                                  circle({50, 50}, 30), circle({50, 50}, 10)});
  ASSERT_TRUE(use) << use.error().message;
  EXPECT_NEAR(use->used_mm2, pi * (1600 - 900 + 100), 1e-9);
  EXPECT_EQ(use->part_count, 2U);
  EXPECT_EQ(use->hole_count, 1U);
}

// At the published scale of 1.45 pixels per mm, with borders as smooth as a drawing
// program makes them: the exact share by hand, to 0.01 % of the sheet.
TEST(MaterialUse, OfAPictureIsThatOfItsGrey) {
  constexpr double kScale = 1.45;
  constexpr int kWidth = 870;
  constexpr int kHeight = 580;
  std::vector<std::uint16_t> brightness;
  const auto is_part = [](double x, double y) {
    const double d = std::hypot(std::fmod(x, 150) - 75, std::fmod(y, 200) - 100);
    return d < 61.3 && d >= 17.9;
  };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      int inside = 0;
      for (int k = 0; k < 16; ++k) {
        const double sub_x = (x + (k % 4 + 0.5) / 4) / kScale;
        const double sub_y = (y + (k / 4 + 0.5) / 4) / kScale;
        inside += is_part(sub_x, sub_y) ? 1 : 0;
      }
      brightness.push_back(static_cast<std::uint16_t>(65535 - 65535 * inside / 16));
    }
  }
  const auto use = MaterialUseOf(brightness, kScale);
  ASSERT_TRUE(use);
  EXPECT_NEAR(use->sheet_mm2, 240'000, 1e-6);
  EXPECT_NEAR(use->use_percent, 100 * 8 * pi * (61.3 * 61.3 - 17.9 * 17.9) / 240'000,
              0.01);
}

TEST(MaterialUse, RefusesADrawingWithoutASheet) {
  const auto two = MaterialUseOf({Plate({0, 0}, {10, 10}), Plate({20, 0}, {10, 10})});
  ASSERT_FALSE(two);
  EXPECT_THAT(two.error().message, HasSubstr("2 contours are outermost"));
  const auto crossing = MaterialUseOf({Plate({0, 0}, {10, 10}), Plate({5, 5}, {10, 10})});
  ASSERT_FALSE(crossing);
  EXPECT_FALSE(MaterialUseOf(std::vector<std::uint16_t>{}, 1));
}

}  // namespace
}  // namespace intaglio::contour
