#include "engrave/drawing/clip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/pieces.h"
#include "tests/engrave/drawing/outline_oracles.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

Curve CurveOf(PointList points, bool closed = true) {
  return {{Polyline{std::move(points)}}, closed};
}

Curve BoxFrom(double left, double bottom, double right, double top) {
  return CurveOf(
      {{left, bottom, 0}, {right, bottom, 0}, {right, top, 0}, {left, top, 0}});
}

Curve CircleAt(const Vec3& center_mm, double radius_mm) {
  return {{EllipticArc{center_mm, {radius_mm, 0, 0}, {0, radius_mm, 0}, 0, 2 * pi}},
          true};
}

FlatDrawing Flat(const std::vector<Curve>& curves) {
  Drawing drawing;
  drawing.curves = curves;
  auto flat = Flatten(drawing);
  EXPECT_TRUE(flat);
  return flat ? *flat : FlatDrawing{};
}

int WindingOf(const std::vector<Curve>& curves, const Vec2& at) {
  return WindingAt(Flat(curves), at);
}

bool IsIn(const std::vector<ClipShape>& shapes, const Vec2& at) {
  return std::ranges::any_of(shapes, [&](const ClipShape& shape) {
    const int winding = WindingOf(shape.outlines, at);
    return shape.even_odd ? winding % 2 != 0 : winding != 0;
  });
}

double DistanceTo(const std::vector<Curve>& curves, const Vec2& at) {
  return DistanceToCurves(Flat(curves), at);
}

double DistanceTo(const std::vector<ClipShape>& shapes, const Vec2& at) {
  double nearest = 1e300;
  for (const ClipShape& shape : shapes)
    nearest = std::min(nearest, DistanceTo(shape.outlines, at));
  return nearest;
}

std::vector<Curve> Inside(const std::vector<ClipShape>& shapes, const Curve& curve,
                          bool filled) {
  ClipWork work;
  const auto area = ClipArea::OfShapes(shapes, work);
  std::vector<Curve> inside;
  EXPECT_TRUE(area && area->Cut(curve, filled, work, inside));
  return inside;
}

double AreaOf(const std::vector<Curve>& curves) {
  double twice = 0;
  for (const FlatCurve& curve : Flat(curves).curves) {
    const std::size_t n = curve.points_mm.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 &p = curve.points_mm[i], &q = curve.points_mm[(i + 1) % n];
      twice += p.x() * q.y() - p.y() * q.x();
    }
  }
  return twice / 2;
}

/// Polygons that cross themselves and each other. On a grid they share corners and run
/// along each other.
class RandomShapes {
 public:
  RandomShapes(unsigned seed, bool on_grid) : random_(seed), on_grid_(on_grid) {}

  Vec2 Place() {
    std::uniform_real_distribution<double> at(0, 10);
    const Vec2 place(at(random_), at(random_));
    return on_grid_ ? Vec2(place.array().round()) : place;
  }
  Curve Polygon(std::size_t corners) {
    PointList points;
    while (points.size() < corners) {
      const Vec2 p = Place();
      points.emplace_back(p.x(), p.y(), 0);
    }
    return CurveOf(std::move(points));
  }
  std::vector<ClipShape> Shapes() {
    std::vector<ClipShape> shapes(1 + random_() % 3);
    for (ClipShape& shape : shapes) {
      shape.even_odd = random_() % 2 == 0;
      for (std::size_t i = 0; i < 1 + random_() % 2; ++i)
        shape.outlines.push_back(Polygon(3 + random_() % 8));
    }
    return shapes;
  }

 private:
  std::mt19937 random_;
  bool on_grid_;
};

// Brute force: the winding numbers of places at random. Near an edge, by more than the
// tolerance of the border, either is right.
TEST(Clip, AreasAreWhatBothHaveByEveryRule) {
  for (unsigned seed = 1900; seed < 2200; ++seed) {
    RandomShapes random(seed, seed % 2 == 0);
    const auto shapes = random.Shapes();
    const Curve area = random.Polygon(3 + seed % 7);
    const auto inside = Inside(shapes, area, true);
    RandomShapes places(seed + 1000, false);
    for (int i = 0; i < 100; ++i) {
      const Vec2 at = places.Place();
      if (DistanceTo(shapes, at) < 3e-3 || DistanceTo({area}, at) < 3e-3) continue;
      const int before = IsIn(shapes, at) ? WindingOf({area}, at) : 0;
      const int now = WindingOf(inside, at);
      ASSERT_EQ(now % 2 != 0, before % 2 != 0) << seed << " at " << at.transpose();
      ASSERT_EQ(now > 0, before > 0) << seed << " at " << at.transpose();
      ASSERT_EQ(now < 0, before < 0) << seed << " at " << at.transpose();
    }
  }
}

TEST(Clip, LinesAreKeptWhereTheirPlacesAreInside) {
  for (unsigned seed = 1900; seed < 2200; ++seed) {
    RandomShapes random(seed, seed % 2 == 0);
    const auto shapes = random.Shapes();
    Curve line = random.Polygon(2 + seed % 7);
    line.closed = seed % 3 == 0;
    const auto inside = Inside(shapes, line, false);
    const FlatCurve flat = Flat({line}).curves.at(0);
    const std::size_t n = flat.points_mm.size();
    for (std::size_t k = 0; k + (flat.closed ? 0 : 1) < n; ++k) {
      for (const double share : {0.013, 0.21, 0.47, 0.68, 0.91}) {
        const Vec3 place =
            flat.points_mm[k] + share * (flat.points_mm[(k + 1) % n] - flat.points_mm[k]);
        const Vec2 at = place.head<2>();
        if (DistanceTo(shapes, at) < 5e-3) continue;
        const double distance = inside.empty() ? 1 : DistanceTo(inside, at);
        // Another line may pass near a place that is outside.
        if (IsIn(shapes, at)) {
          ASSERT_LT(distance, 1e-9) << seed << " at " << at.transpose();
        } else {
          ASSERT_GT(distance, 4e-3) << seed << " at " << at.transpose();
        }
      }
    }
  }
}

TEST(Clip, OfBothIsInEach) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    RandomShapes random(seed, seed % 2 == 0);
    const auto a = random.Shapes(), b = random.Shapes();
    ClipWork work;
    const auto area = ClipArea::OfBoth(*ClipArea::OfShapes(a, work),
                                       *ClipArea::OfShapes(b, work), work);
    ASSERT_TRUE(area) << seed;
    const ClipShape shape = area->AsShape();
    RandomShapes places(seed + 1000, false);
    for (int i = 0; i < 100; ++i) {
      const Vec2 at = places.Place();
      if (DistanceTo(a, at) < 1e-4 || DistanceTo(b, at) < 1e-4) continue;
      ASSERT_EQ(WindingOf(shape.outlines, at), IsIn(a, at) && IsIn(b, at) ? 1 : 0)
          << seed << " at " << at.transpose();
    }
  }
}

// A ring: a disc of radius 5 with a hole of 2. The areas are known.
TEST(Clip, HolesAreLeftOutByTheirRule) {
  const std::vector<Curve> circles = {CircleAt({0, 0, 0}, 5), CircleAt({0, 0, 0}, 2)};
  const Curve half = BoxFrom(0, -10, 10, 10);
  // Chords are shorter than arcs: by 1e-4 of the radius, as flattening allows.
  EXPECT_NEAR(AreaOf(Inside({{circles, true}}, half, true)), 21 * pi / 2, 0.01);
  EXPECT_NEAR(AreaOf(Inside({{circles, false}}, half, true)), 25 * pi / 2, 0.01);
  EXPECT_NEAR(AreaOf(Inside({{circles, true}}, BoxFrom(-9, -9, 9, 9), true)), 21 * pi,
              0.02);
  const auto chord = Inside({{circles, true}}, CurveOf({{-9, 0, 0}, {9, 0, 0}}), false);
  ASSERT_EQ(chord.size(), 2U);
  EXPECT_NEAR(BeginOf(chord[1].pieces[0]).x(), 2, 1e-3);
  EXPECT_NEAR(EndOf(chord[1].pieces[0]).x(), 5, 1e-3);
}

// What runs along the border is inside, on every side and with rounding of both signs.
TEST(Clip, TheBorderIsInsideAndDoesNotFlicker) {
  const std::vector<ClipShape> box = {{{BoxFrom(10, 10, 20, 30)}, false}};
  for (const double off : {-1e-3, -1e-7, -1e-12, 0.0, 1e-12, 1e-7, 1e-3}) {
    const auto line = Inside(box, CurveOf({{0, 10 + off, 0}, {50, 10 + off, 0}}), false);
    ASSERT_EQ(line.size(), 1U) << off;
    EXPECT_NEAR(BeginOf(line[0].pieces[0]).x(), 10, 5e-3) << off;
    EXPECT_NEAR(EndOf(line[0].pieces[0]).x(), 20, 5e-3) << off;
    const Curve same = BoxFrom(10 + off, 10 + off, 20 + off, 30 + off);
    EXPECT_NEAR(AreaOf(Inside(box, same, true)), 200, 0.05) << off;
    EXPECT_EQ(Inside(box, same, true).size(), 1U) << off;
    EXPECT_EQ(Inside(box, same, false).size(), 1U) << off;
    EXPECT_EQ(Inside(box, CurveOf({{20 + off, 15, 0}}, false), false).size(), 1U) << off;
  }
  // A circle cut by the same circle, drawn from another angle on.
  Curve turned = CircleAt({3, 4, 0}, 5);
  std::get<EllipticArc>(turned.pieces[0]).begin_rad = 0.3;
  const std::vector<ClipShape> circle = {{{CircleAt({3, 4, 0}, 5)}, false}};
  for (const bool filled : {false, true}) {
    const auto inside = Inside(circle, turned, filled);
    ASSERT_EQ(inside.size(), 1U);
    EXPECT_TRUE(std::holds_alternative<EllipticArc>(inside[0].pieces[0])) << "exact";
  }
}

// Shapes that share an edge have no border there.
TEST(Clip, ShapesThatTouchAreOne) {
  const std::vector<ClipShape> boxes = {{{BoxFrom(0, 0, 10, 10)}, true},
                                        {{BoxFrom(10, 0, 20, 10)}, true}};
  EXPECT_EQ(Inside(boxes, CurveOf({{1, 5, 0}, {19, 5, 0}}), false).size(), 1U);
  const auto area = Inside(boxes, BoxFrom(5, -5, 15, 5), true);
  ASSERT_EQ(area.size(), 1U);
  EXPECT_NEAR(AreaOf(area), 50, 1e-6);
}

// The direction decides which of a drawing's loops are holes by the rule of directions.
TEST(Clip, LoopsKeepTheirDirection) {
  const std::vector<ClipShape> box = {{{BoxFrom(0, 0, 10, 10)}, false}};
  Curve hole = BoxFrom(5, 5, 15, 8);
  EXPECT_NEAR(AreaOf(Inside(box, hole, true)), 15, 1e-6);
  auto& points = std::get<Polyline>(hole.pieces[0]).points_mm;
  std::ranges::reverse(points);
  EXPECT_NEAR(AreaOf(Inside(box, hole, true)), -15, 1e-6);
}

TEST(Clip, AClosedLineThatIsCutGoesOnOverItsBeginning) {
  const std::vector<ClipShape> box = {{{BoxFrom(-1, -1, 5, 11)}, false}};
  const auto inside = Inside(box, BoxFrom(0, 0, 10, 10), false);
  ASSERT_EQ(inside.size(), 1U);
  const auto flat = Flat(inside);
  EXPECT_EQ(flat.curves[0].points_mm.size(), 4U);
  EXPECT_NEAR(DistanceTo(inside, {0, 0}), 0, 1e-9);
}

TEST(Clip, NothingIsWithinNoShape) {
  EXPECT_TRUE(Inside({}, BoxFrom(0, 0, 1, 1), true).empty());
  EXPECT_TRUE(Inside({}, BoxFrom(0, 0, 1, 1), false).empty());
}

// The outline of an area follows that of the clip, whose height is not known.
TEST(Clip, WhatIsNotLevelIsCutAsALineAlone) {
  ClipWork work;
  const auto area = ClipArea::OfShapes({{{BoxFrom(0, 0, 5, 10)}, false}}, work);
  ASSERT_TRUE(area);
  const Curve slope = CurveOf({{0, 1, 0}, {10, 1, 20}, {10, 5, 20}});
  std::vector<Curve> inside;
  EXPECT_FALSE(area->Cut(slope, true, work, inside));
  EXPECT_TRUE(inside.empty());
  ASSERT_TRUE(area->Cut(slope, false, work, inside));
  ASSERT_EQ(inside.size(), 1U);
  EXPECT_NEAR(EndOf(inside[0].pieces[0]).z(), 10, 1e-9);
}

TEST(Clip, CurvesBeyondReachAreNotCut) {
  ClipWork work;
  const double far = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(ClipArea::OfShapes({{{BoxFrom(0, 0, far, 10)}, false}}, work));
  const auto area = ClipArea::OfShapes({{{BoxFrom(0, 0, 5, 10)}, false}}, work);
  std::vector<Curve> inside;
  EXPECT_FALSE(area && area->Cut(BoxFrom(0, 0, 1e10, 10), true, work, inside));
}

/// A star of so many corners about 5, 5.
Curve StarOf(int corners) {
  PointList points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * pi * i / corners;
    const double radius = i % 2 == 0 ? 5 : 5 - 10.0 / corners;
    points.emplace_back(5 + radius * std::cos(angle), 5 + radius * std::sin(angle), 0);
  }
  return CurveOf(std::move(points));
}

// Pairs of edges that are compared, and not time: quadratic work would be 16 times more.
TEST(Clip, WorkGrowsAsTheNumberOfEdges) {
  const auto work_of = [](int corners) {
    ClipWork work;
    const auto area = ClipArea::OfShapes({{{StarOf(corners)}, false}}, work);
    EXPECT_TRUE(area);
    std::vector<Curve> inside;
    for (int i = 0; i < 500 && area; ++i) {
      const double x = 0.02 * i;
      EXPECT_TRUE(area->Cut(BoxFrom(x, 4, x + 0.1, 6), i % 2 == 0, work, inside));
    }
    return ClipWork().pairs_left - work.pairs_left;
  };
  EXPECT_LT(work_of(20'000), 5 * work_of(5'000));
}

TEST(Clip, CurvesAreNotCutWhenTheWorkIsTooMuch) {
  ClipWork none{10};
  EXPECT_FALSE(ClipArea::OfShapes({{{StarOf(100)}, false}}, none));
  ClipWork work;
  const auto area = ClipArea::OfShapes({{{StarOf(100)}, false}}, work);
  ASSERT_TRUE(area);
  std::vector<Curve> inside;
  for (const bool filled : {false, true}) {
    ClipWork little{100};
    EXPECT_FALSE(area->Cut(StarOf(200), filled, little, inside));
  }
  EXPECT_TRUE(inside.empty());
}

}  // namespace
}  // namespace intaglio::drawing
