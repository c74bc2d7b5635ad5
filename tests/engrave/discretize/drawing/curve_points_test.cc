#include "engrave/discretize/drawing/curve_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "engrave/core/check.h"
#include "engrave/discretize/drawing/place_drawing.h"
#include "tests/engrave/discretize/oracles.h"

namespace intaglio::discretize {
namespace {

using drawing::FlatCurve;
using drawing::FlatDrawing;
using std::numbers::pi;

PointList PointsOf(const FlatDrawing& placed, const CurveOptions& options) {
  const auto source = MakeCurvePoints(placed, options);
  EXPECT_TRUE(source.has_value()) << (source ? "" : source.error().message);
  if (!source) return {};
  SpacedCloud cloud;
  EXPECT_TRUE((*source)->AddPoints({}, 0, {}, cloud).has_value());
  return cloud.points_mm;
}

FlatCurve Ring(double radius_mm, int corners, const Vec3& center = Vec3::Zero(),
               bool clockwise = false) {
  FlatCurve ring{{}, true, 0, 0};
  for (int i = 0; i < corners; ++i) {
    const double angle = (clockwise ? -2 : 2) * pi * i / corners;
    ring.points_mm.push_back(center +
                             radius_mm * Vec3(std::cos(angle), std::sin(angle), 0));
  }
  return ring;
}
FlatCurve Square(double size_mm) {
  return {
      {{0, 0, 0}, {size_mm, 0, 0}, {size_mm, size_mm, 0}, {0, size_mm, 0}}, true, 0, 0};
}

double NearestTo(const Vec3& p, const PointList& points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& q : points) nearest = std::min(nearest, (p - q).norm());
  return nearest;
}
bool Has(const PointList& points, const Vec3& p) { return NearestTo(p, points) < 1e-9; }

TEST(CurvePoints, CornersOfClosedCurvesStayPoints) {
  CurveOptions options;
  options.distance_mm = 0.7;
  const PointList points = PointsOf({{Square(10)}}, options);
  for (const Vec3& corner : Square(10).points_mm) EXPECT_TRUE(Has(points, corner));
  // 10 / (0.7 * 1.004) = 14.2: 14 steps a side.
  EXPECT_EQ(points.size(), 56U);
  EXPECT_NEAR(MinDistance(points), 10.0 / 14, 1e-12);
}

TEST(CurvePoints, WithoutCornersTheStepIsTheSameAllRound) {
  CurveOptions options;
  options.keep_corners = false;
  options.distance_mm = 0.9;
  const FlatDrawing circle{{Ring(10, 2000)}};
  const PointList points = PointsOf(circle, options);
  EXPECT_EQ(points.size(), 69U);  // 62.83 / (0.9 * 1.004) = 69.5
  options.keep_corners = true;    // a circle has none
  EXPECT_EQ(PointsOf(circle, options), points);
}

TEST(CurvePoints, OpenCurvesWithAndWithoutEndPoints) {
  const FlatDrawing bent{{{{{0, 0, 0}, {10, 0, 0}, {10, 5, 0}}, false, 0, 0}}};
  CurveOptions options;
  const PointList with = PointsOf(bent, options);
  EXPECT_TRUE(Has(with, {0, 0, 0}));
  EXPECT_TRUE(Has(with, {10, 0, 0}));
  EXPECT_TRUE(Has(with, {10, 5, 0}));
  EXPECT_EQ(with.size(), 10U + 4U);  // 9 steps, 4 steps, and the last end

  options.insert_end_points = false;
  const PointList without = PointsOf(bent, options);
  EXPECT_TRUE(Has(without, {10, 0, 0}));
  EXPECT_FALSE(Has(without, {0, 0, 0}));
  EXPECT_FALSE(Has(without, {10, 5, 0}));
  EXPECT_NEAR(NearestTo({0, 0, 0}, without), 0.5, 0.06);
  EXPECT_NEAR(NearestTo({10, 5, 0}, without), 0.5, 0.12);
  EXPECT_GE(MinDistance(without), 1);
}

TEST(CurvePoints, CornersNearerThanTheDistanceDoNotCrowd) {
  // A saw of teeth of 0.3 mm under a distance of 1 mm.
  FlatCurve saw{{}, false, 0, 0};
  for (int i = 0; i < 200; ++i) saw.points_mm.emplace_back(0.2 * i, i % 2 * 0.2, 0);
  const PointList points = PointsOf({{saw}}, {});
  for (std::size_t i = 2; i < points.size(); ++i) {
    EXPECT_GE((points[i] - points[i - 1]).norm(), 0.6);  // arc of 1 over two teeth
  }
}

TEST(CurvePoints, PointsAndShortCurvesGiveOne) {
  const FlatDrawing placed{{{{{1, 2, 3}}, false, 0, 0},
                            {{{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.2, 0}}, false, 0, 0}}};
  EXPECT_EQ(PointsOf(placed, {}).size(), 2U);
}

TEST(CurvePoints, LayersAndTwist) {
  CurveOptions options;
  options.layer_count = 4;
  options.layer_distance_mm = 0.5;
  options.layer_direction = {0, 0, -3};
  options.twist_phase_ratio = 0.25;
  const PointList points = PointsOf({{Ring(10, 720, {0, 0, 5})}}, options);
  ASSERT_EQ(points.size() % 4, 0U);
  const std::size_t n = points.size() / 4;
  for (std::size_t layer = 0; layer < 4; ++layer) {
    const Vec3& first = points[(3 - layer) * n];  // the source gives them by height
    EXPECT_NEAR(first.z(), 5 - 0.5 * static_cast<double>(layer), 1e-12);
    const double angle = std::atan2(first.y(), first.x());
    EXPECT_NEAR(
        angle, 0.25 * static_cast<double>(layer) * 2 * pi / static_cast<double>(n), 1e-4);
  }
}

TEST(CurvePoints, TwistShiftsTheLayersOfCurvesWithCorners) {
  CurveOptions options;
  options.layer_count = 3;
  options.layer_distance_mm = 2;
  options.twist_phase_ratio = 0.5;
  const PointList points = PointsOf({{Square(10)}}, options);
  PointList layer[3];
  for (const Vec3& p : points) layer[std::lround(p.z() / 2)].push_back(p);
  ASSERT_EQ(layer[0].size(), 36U);  // 10 / 1.004 = 9.96: 9 steps a side
  for (int i = 0; i < 3; ++i) EXPECT_EQ(layer[i].size(), 36U);
  // The second layer lies half a step behind the first, the third a whole one: as it.
  const double step_mm = 10.0 / 9;
  for (const Vec3& corner : Square(10).points_mm) {
    EXPECT_TRUE(Has(layer[0], corner));
    EXPECT_NEAR(NearestTo(corner + Vec3(0, 0, 2), layer[1]), step_mm / 2, 1e-12);
    EXPECT_TRUE(Has(layer[2], corner + Vec3(0, 0, 4)));
  }
  for (const Vec3& p : layer[1]) {
    const double along = std::fmod(p.x() + p.y(), step_mm) / step_mm;  // on two sides
    if (p.x() > 1e-9 && p.y() > 1e-9 && p.x() < 10 - 1e-9) continue;
    if (p.y() < 1e-9 || p.x() > 10 - 1e-9) {
      EXPECT_NEAR(along, 0.5, 1e-9) << p.transpose();
    }
  }
}

/// Every place inside (by the oracle) is near a point, and points keep the distance.
template <typename IsInside>
void ExpectEvenFill(const PointList& points, double distance_mm,
                    const IsInside& is_inside, double half_width_mm) {
  EXPECT_GE(MinDistance(points), distance_mm * 0.999);  // chords of the outline
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-half_width_mm, half_width_mm);
  double widest = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p(place(random), place(random), 0);
    if (is_inside(p)) widest = std::max(widest, NearestTo(p, points));
  }
  EXPECT_LE(widest, 1.12 * distance_mm);
  for (const Vec3& p : points) {
    EXPECT_TRUE(is_inside(p * (1 - 1e-3)) || is_inside(p * (1 + 1e-3))) << p.transpose();
  }
}

TEST(CurvePoints, EvenOddFillLeavesTheHole) {
  CurveOptions options;
  options.distance_mm = 0.3;
  options.fill = CurveFill::kEvenOdd;
  const FlatDrawing rings{{Ring(5, 600), Ring(2, 300)}};
  ExpectEvenFill(
      PointsOf(rings, options), 0.3,
      [](const Vec3& p) { return p.norm() < 5 && p.norm() > 2; }, 5);
}

// Up to the outline also between teeth of 0.8 to 4 spacings and into sharp spikes.
TEST(CurvePoints, FillReachesTheOutlineOfTeethAndSpikes) {
  CurveOptions options;
  options.distance_mm = 0.3;
  options.fill = CurveFill::kEvenOdd;
  for (const double width_mm : {0.24, 0.5, 1.2}) {
    FlatCurve comb{{{-5, -5, 0}, {5, -5, 0}, {5, -4, 0}}, true};
    double x = 5;
    for (; x - 2 * width_mm > -5; x -= 2 * width_mm)
      for (const Vec3& corner : {Vec3(x, -4, 0), Vec3(x, 5, 0), Vec3(x - width_mm, 5, 0),
                                 Vec3(x - width_mm, -4, 0)})
        if (corner.x() < 5 || corner.y() > 0) comb.points_mm.push_back(corner);
    comb.points_mm.emplace_back(-5, -4, 0);
    const auto is_inside = [&](const Vec3& p) {
      if (p.y() < -4) return p.y() > -5 && std::abs(p.x()) < 5;
      const double from_right = 5 - p.x();
      return p.x() > x && p.y() < 5 && p.x() < 5 &&
             std::fmod(from_right, 2 * width_mm) < width_mm;
    };
    const PointList points = PointsOf({{comb}}, options);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-5, 5);
    for (int k = 0; k < 3000; ++k) {
      const Vec3 p(place(random), place(random), 0);
      if (!is_inside(p)) continue;
      EXPECT_LE(NearestTo(p, points), 1.12 * options.distance_mm)
          << width_mm << " mm at " << p.transpose();
    }
  }
}

TEST(CurvePoints, NonZeroFillOfOverlappingAndOfTurnedRings) {
  CurveOptions options;
  options.distance_mm = 0.3;
  options.fill = CurveFill::kNonZero;
  const FlatDrawing same{{Ring(5, 600), Ring(2, 300)}};
  ExpectEvenFill(
      PointsOf(same, options), 0.3, [](const Vec3& p) { return p.norm() < 5; }, 5);
  const FlatDrawing turned{{Ring(5, 600), Ring(2, 300, Vec3::Zero(), true)}};
  ExpectEvenFill(
      PointsOf(turned, options), 0.3,
      [](const Vec3& p) { return p.norm() < 5 && p.norm() > 2; }, 5);
}

TEST(CurvePoints, FillLiesInThePlaneOfTheDrawing) {
  FlatDrawing placed{{Square(6)}};
  for (Vec3& p : placed.curves[0].points_mm) p = Vec3(p.x(), 4, p.y());  // upright
  CurveOptions options;
  options.distance_mm = 0.5;
  options.fill = CurveFill::kEvenOdd;
  const PointList points = PointsOf(placed, options);
  EXPECT_GT(points.size(), 100U);
  for (const Vec3& p : points) EXPECT_NEAR(p.y(), 4, 1e-9);
  placed.curves[0].points_mm[2].y() = 5;
  const auto bent = MakeCurvePoints(placed, options);
  ASSERT_FALSE(bent.has_value());
  EXPECT_EQ(bent.error().code, ErrorCode::kUnsupported);
}

TEST(CurvePoints, TooManyAndBrokenOptions) {
  CurveOptions options;
  options.distance_mm = 0.01;
  options.layer_count = 10;
  options.layer_distance_mm = 1;
  const auto many = MakeCurvePoints({{Square(1e6)}}, options);
  ASSERT_FALSE(many.has_value());
  EXPECT_EQ(many.error().code, ErrorCode::kTooLarge);
  options.layer_count = 1;
  options.fill = CurveFill::kEvenOdd;
  const auto wide = MakeCurvePoints({{Square(1e3)}}, options);
  ASSERT_FALSE(wide.has_value());
  EXPECT_EQ(wide.error().code, ErrorCode::kTooLarge);
  options.distance_mm = 0.001;
  EXPECT_THROW((void)MakeCurvePoints({}, options), PreconditionError);
}

TEST(PlaceDrawing, CirclesAreExactWhereTheyAre) {
  drawing::Drawing circle;
  circle.curves.push_back(
      {{drawing::EllipticArc{{7, 7, 0}, {0.01, 0, 0}, {0, 0.01, 0}, 0, 2 * pi}}, true});
  mesh::Placement placement;
  placement.rotation_rad = {pi / 2, 0, 0};
  placement.fit = mesh::FitHeight{40};
  const auto placed = PlaceDrawing(circle, placement, {60, 30, 80});
  ASSERT_TRUE(placed.has_value()) << placed.error().message;
  // Flattened before it were placed, it would be a polygon off by 20 times the tolerance.
  for (const Vec3& p : placed->flat.curves[0].points_mm) {
    EXPECT_NEAR((p - Vec3(30, 15, 40)).norm(), 20, 0.002);
    EXPECT_NEAR(p.y(), 15, 1e-9);
  }
  EXPECT_NEAR(std::abs(placed->normal.y()), 1, 1e-12);
  EXPECT_FALSE(PlaceDrawing({}, placement, {60, 30, 80}).has_value());
}

// A disc as its outline and again, from another point and in two halves, as a hatch of it
// is written: its inside is filled as that of the outline alone.
TEST(PlaceDrawing, WhatIsThereTwiceIsFilledOnce) {
  const drawing::EllipticArc whole{{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, 0, 2 * pi};
  drawing::EllipticArc half = whole, other = whole;
  half.begin_rad = 1;
  half.sweep_rad = other.sweep_rad = pi;
  other.begin_rad = 1 + pi;
  drawing::Drawing once;
  once.curves.push_back({{whole}, true});
  drawing::Drawing twice = once;
  twice.curves.push_back({{half, other}, true});
  CurveOptions options;
  options.distance_mm = 0.5;
  options.fill = CurveFill::kEvenOdd;
  const auto points_of = [&](const drawing::Drawing& drawing) {
    const auto placed = PlaceDrawing(drawing, {}, {40, 40, 40});
    EXPECT_TRUE(placed.has_value());
    return placed ? PointsOf(placed->flat, options) : PointList{};
  };
  const PointList points = points_of(twice);
  // About a point for each square of the distance.
  EXPECT_GT(static_cast<double>(points.size()), 0.9 * 81 * pi / 0.25);
  EXPECT_EQ(points, points_of(once));
}

}  // namespace
}  // namespace intaglio::discretize
