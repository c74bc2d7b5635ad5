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
  for (const Edges& of_a : a.loops) {
    for (const Edges& of_b : b.loops) {
      for (const Edge& e : of_a)
        for (const Edge& f : of_b) gap = std::min(gap, GapBetween(e, f).distance_mm);
    }
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
  EXPECT_EQ(nest->parts[0].quarter_turns % 2, 1);
  ExpectNested(parts, *nest, options);
  EXPECT_FALSE(NestParts(parts, {{600, 400}, 2, 5, false}));
}

/// A polygon with a corner at each of these places.
Region Polygon(const std::vector<Vec2>& corners) {
  Edges loop;
  for (std::size_t i = 0; i < corners.size(); ++i)
    loop.push_back(MakeLine(corners[i], corners[(i + 1) % corners.size()]));
  return {{loop}};
}

std::vector<Region> Angles(int count) {
  const Region angle = Polygon({{5, 5}, {35, 5}, {35, 15}, {15, 15}, {15, 45}, {5, 45}});
  return std::vector<Region>(static_cast<std::size_t>(count), angle);
}

// By hand: 3 x 4 boxes of 42 x 32 mm fit on a sheet, twelve angles. Each angle has half
// of its box.
TEST(Nest, PartsThatInterlockLieInEachOther) {
  const NestOptions options{{150, 150}, 2, 2, true};
  const std::vector<Region> parts = Angles(19);
  const auto nest = NestParts(parts, options);
  ASSERT_TRUE(nest) << nest.error().message;
  EXPECT_EQ(nest->sheet_count, 1U);
  EXPECT_NEAR(nest->use_percent, 100 * 19 * 600 / 22500.0, 1e-9);
  ExpectNested(parts, *nest, options);
}

TEST(Nest, ASmallPartLiesInTheHoleOfALargeOne) {
  std::vector<Region> parts{Rectangular({0, 0}, {90, 90}), Rectangular({3, 4}, {30, 30})};
  const Region hole = Rectangular({10, 10}, {70, 70});
  Edges around;
  for (auto edge = hole.loops[0].rbegin(); edge != hole.loops[0].rend(); ++edge)
    around.push_back(Reversed(*edge));
  parts[0].loops.push_back(around);
  const NestOptions options{{100, 100}, 2, 4, true};
  const auto nest = NestParts(parts, options);
  ASSERT_TRUE(nest) << nest.error().message;
  EXPECT_EQ(nest->sheet_count, 1U);
  ExpectNested(parts, *nest, options);
}

// Shapes with bays, arcs and holes in all directions: apart from each other by the gap,
// and never on more sheets than their boxes.
TEST(Nest, OutlinesOfAnyShapeStayApart) {
  std::mt19937 random(5);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  for (int round = 0; round < 4; ++round) {
    std::vector<Region> parts;
    for (int k = 0; k < 16; ++k) {
      const double a = number(20, 60), b = number(20, 60), t = number(4, 9);
      const Vec2 at(number(-50, 50), number(-50, 50));
      std::vector<Vec2> corners;
      if (k % 3 == 0)
        corners = {{0, 0},     {b, 0},     {b, t}, {t, t},
                   {t, a - t}, {b, a - t}, {b, a}, {0, a}};
      else if (k % 3 == 1)
        corners = {{0, 0},           {b, 0},           {b, t},           {(b + t) / 2, t},
                   {(b + t) / 2, a}, {(b - t) / 2, a}, {(b - t) / 2, t}, {0, t}};
      else
        corners = {{0, 0}, {b, 0}, {0, a}};
      for (Vec2& corner : corners) corner += at;
      parts.push_back(Polygon(corners));
      if (k % 5 == 4) parts.back() = {{{MakeArc(at, a / 2, 0, 2 * pi)}}};
    }
    const NestOptions options{{200, 160}, round % 2 == 0 ? 2.0 : 0.0, 5, round % 4 != 3};
    const auto nest = NestParts(parts, options);
    ASSERT_TRUE(nest) << nest.error().message;
    ExpectNested(parts, *nest, options);
  }
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
