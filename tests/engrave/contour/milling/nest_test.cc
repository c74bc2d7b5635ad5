#include "engrave/contour/milling/nest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "engrave/contour/gaps.h"
#include "engrave/contour/milling/material_use.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Region Rectangular(const Vec2& at, const Vec2& sides) {
  const Vec2 b = at + sides;
  return {{{MakeLine(at, {b.x(), at.y()}), MakeLine({b.x(), at.y()}, b),
            MakeLine(b, {at.x(), b.y()}), MakeLine({at.x(), b.y()}, at)}}};
}

double GapOf(const Region& a, const Region& b) {
  double gap = 1e300;
  for (const Edge& e : a.loops[0]) {
    for (const Edge& f : b.loops[0]) gap = std::min(gap, GapBetween(e, f).distance_mm);
  }
  return gap;
}

/// Parts lie in their sheets and apart from each other: by the distances of their edges
/// and common areas, which know nothing of boxes.
void ExpectNested(const std::vector<Region>& parts, const Nest& nest,
                  const NestOptions& options) {
  std::vector<Region> placed;
  for (const NestedPart& part : nest.parts) {
    placed.push_back(Placed(parts[part.part], part));
    EXPECT_NEAR(AreaOf(placed.back()), AreaOf(parts[part.part]), 1e-9);
    for (const Edge& edge : placed.back().loops[0]) {
      for (int k = 0; k <= 16; ++k) {
        const Vec2 p = PointAt(edge, k / 16.0 * edge.length_mm);
        EXPECT_GE(p.minCoeff(), options.margin_mm - 1e-6);
        EXPECT_LE((p - options.sheet_mm).maxCoeff(), -options.margin_mm + 1e-6);
      }
    }
  }
  for (std::size_t a = 0; a < placed.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (nest.parts[a].sheet != nest.parts[b].sheet) continue;
      EXPECT_GE(GapOf(placed[a], placed[b]), options.gap_mm - 1e-6);
      EXPECT_FALSE(IsInside(placed[a], placed[b].loops[0][0].begin_mm));
      EXPECT_FALSE(IsInside(placed[b], placed[a].loops[0][0].begin_mm));
    }
  }
}

TEST(Nest, PutsRectanglesAndDiscsApartFromEachOther) {
  std::mt19937 random(3);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  std::vector<Region> parts;
  double area = 0;
  for (int k = 0; k < 40; ++k) {
    parts.push_back(
        k % 4 == 3 ? Region{{{MakeArc({number(-9, 9), 3}, number(5, 30), 0, 2 * pi)}}}
                   : Rectangular({number(-99, 99), number(-99, 99)},
                                 {number(10, 160), number(10, 90)}));
    area += AreaOf(parts.back());
  }
  const NestOptions options;
  const auto nest = NestParts(parts, options);
  ASSERT_TRUE(nest) << nest.error().message;
  ExpectNested(parts, *nest, options);
  EXPECT_NEAR(nest->use_percent, 100 * area / (nest->sheet_count * 240'000), 1e-9);
  // No sheet more than one and a half times the area needs.
  EXPECT_LE(nest->sheet_count, std::ceil(1.5 * area / 240'000));
  EXPECT_GT(nest->use_percent, 50);
}

// By hand: four columns of 143.75 and two rows of 192.5 with gaps and margins of 5 fill
// 600 x 400; turned, only six would fit.
TEST(Nest, FillsASheetThatCanBeFilled) {
  const NestOptions options{{600, 400}, 5, 5, true};
  std::vector<Region> parts;
  for (int k = 0; k < 8; ++k) parts.push_back(Rectangular({7, 9}, {143.75, 192.5}));
  const auto nest = NestParts(parts, options);
  ASSERT_TRUE(nest) << nest.error().message;
  EXPECT_EQ(nest->sheet_count, 1U);
  ExpectNested(parts, *nest, options);
  EXPECT_NEAR(nest->use_percent, 100 * 8 * 143.75 * 192.5 / 240'000, 1e-9);
  parts.push_back(Rectangular({0, 0}, {143.75, 192.5}));
  EXPECT_EQ(NestParts(parts, options)->sheet_count, 2U);
}

TEST(Nest, TurnsPartsThatFitOnlySo) {
  const std::vector<Region> parts{Rectangular({0, 0}, {20, 500})};
  const NestOptions options;
  const auto nest = NestParts(parts, options);
  ASSERT_TRUE(nest) << nest.error().message;
  EXPECT_TRUE(nest->parts[0].turned);
  ExpectNested(parts, *nest, options);
  EXPECT_FALSE(NestParts(parts, {{600, 400}, 2, 5, false}));
}

TEST(Nest, NamesThePartThatDoesNotFit) {
  const auto nest = NestParts(
      std::vector<Region>{Rectangular({0, 0}, {10, 10}), Rectangular({0, 0}, {595, 395})},
      NestOptions{});
  ASSERT_FALSE(nest);
  EXPECT_THAT(nest.error().message, HasSubstr("part 1 of 595 x 395 mm does not fit"));
}

}  // namespace
}  // namespace intaglio::contour
