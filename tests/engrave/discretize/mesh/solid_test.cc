#include "engrave/discretize/mesh/solid.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "engrave/discretize/mesh/solid_lattice.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/surface_checks.h"

namespace intaglio::discretize {
namespace {

std::unique_ptr<PointSource> Solid(const mesh::TriangleMesh& mesh,
                                   const SolidOptions& options) {
  auto source = MakeSolid(mesh, options);
  EXPECT_TRUE(source.has_value());
  return *std::move(source);
}

TEST(Solid, PointsAreExactlyApartAndThinningKeepsThemAll) {
  const auto source = Solid(Icosphere(4, 4, Vec3(5, 6, 7)), {0.3, 1});
  const SpacedCloud points = PointsOf(*source);
  const Evenness even = EvennessOf(points.points_mm);
  EXPECT_GE(even.smallest, 0.3);
  EXPECT_LT(even.variation, 1e-6);
  EXPECT_NEAR(even.mean, 0.3, 1e-6);
  EXPECT_EQ(Thinned(*source).size(), points.size());
}

// 0.48 in single precision is less than 0.48: three quarters of the points were thinned.
TEST(Solid, ThinningKeepsThemAllWhateverTheirDistance) {
  for (double d = 0.3; d < 0.6; d += 0.0137) {
    const SpacedCloud points = PointsOf(*Solid(Cube(5), {d, 1}));
    EXPECT_EQ(Thin(points, {d, 1}).size(), points.size()) << d;
  }
}

TEST(Solid, PointsAreThoseOfTheLatticeInside) {
  const Vec3 centre(5, 6, 7);
  const double r = 4, d = 0.25;
  const SpacedCloud points = PointsOf(*Solid(Icosphere(r, 6, centre), {d, 1}));
  // sqrt(2) points for each cube of the distance; the sphere's surface decides about
  // some 4 pi r^2 / d^2 of them, at random.
  const double expected =
      std::numbers::sqrt2 * 4 / 3 * std::numbers::pi * r * r * r / (d * d * d);
  EXPECT_NEAR(static_cast<double>(points.size()), expected, 0.01 * expected);
  for (const Vec3& p : points.points_mm) ASSERT_LT((p - centre).norm(), r);
  // The largest hole of the lattice is d / sqrt(2) from its points.
  const NearestPoints nearest(points.points_mm);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q = centre + (r - d) * std::cbrt((i + 0.5) / 2000) *
                                Vec3(std::cos(i), std::sin(i) * std::cos(3.7 * i),
                                     std::sin(i) * std::sin(3.7 * i));
    ASSERT_LE(nearest.Distance(q), d / std::numbers::sqrt2 * (1 + 1e-6));
  }
}

// Across each direction of the rows the points of a layer lie on lines as far apart as
// the rows, and on every line the next one is the distance away.
TEST(Solid, RowsAndLayersAreThoseOfItsLattice) {
  const double d = 0.4;
  const PointList points_mm = PointsOf(*Solid(Cube(6), {d, 1.3})).points_mm;
  std::map<double, std::map<std::int64_t, std::vector<double>>> rows;
  for (const double turn_deg : kSolidRowTurnsDeg) {
    const Eigen::Rotation2Dd back(-turn_deg * std::numbers::pi / 180);
    for (const Vec3& p : points_mm) {
      const Vec2 q = back * (p - points_mm.front()).head<2>();
      const double layer = p.z() / (SolidLayerRatio() * 1.3 * d);
      EXPECT_NEAR(layer, std::round(layer), 1e-3);
      // Layers are moved across by thirds of a row.
      const double third = 3 * q.y() / (SolidRowRatio() * d);
      EXPECT_NEAR(third, std::round(third), 1e-3);
      rows[turn_deg + 1000 * std::round(layer)][std::llround(third)].push_back(q.x());
    }
  }
  for (auto& [layer, of_layer] : rows) {
    for (auto& [third, along_mm] : of_layer) {
      EXPECT_EQ((third - of_layer.begin()->first) % 3, 0);
      std::ranges::sort(along_mm);
      for (std::size_t i = 1; i < along_mm.size(); ++i)
        EXPECT_NEAR(along_mm[i] - along_mm[i - 1], d, 1e-5);
    }
  }
}

// Walls and edges that are vertical, and vertices on the lines, do not confuse it.
TEST(Solid, InsideIsAsByFormula) {
  const double d = 0.2;
  const mesh::TriangleMesh box = Cuboid(Vec3(0, 0, 0), Vec3(3, 2, 1));
  const SpacedCloud points = PointsOf(*Solid(box, {d, 1}));
  const double expected = std::numbers::sqrt2 * 6 / (d * d * d);
  EXPECT_NEAR(static_cast<double>(points.size()), expected, 0.15 * expected);
  for (const Vec3& p : points.points_mm) ASSERT_TRUE(box.Bounds().Contains(p));
  const mesh::TriangleMesh torus = Torus(Vec3(0, 0, 0), 4, 1.5, 90, 40);
  for (const Vec3& p : PointsOf(*Solid(torus, {d, 1})).points_mm) {
    ASSERT_LT(std::hypot(p.head<2>().norm() - 4, p.z()), 1.5);
  }
}

TEST(Solid, LayersFollowTheHeightRatio) {
  const auto source = Solid(Cube(5), {0.3, 2});
  const SpacedCloud points = PointsOf(*source);
  EXPECT_EQ(Thin(points, {0.299, 2}).size(), points.size());
  EXPECT_LT(Thin(points, {0.301, 2}).size(), points.size() / 2);
}

TEST(Solid, IsTheSameInEveryCutByHeight) {
  ExpectSameInRanges(*Solid(Torus(Vec3(0, 0, 0), 3, 1, 30, 20), {0.2, 1}),
                     {-0.5, 0, 0.3});
  ExpectSameInRanges(*Solid(Cube(2), {0.2, 3}), {0.5, 1, 2});
}

TEST(Solid, OpenSurfacesGiveNothingWhereTheyAreOpen) {
  SpacedCloud cloud;
  const auto statistics =
      *Solid(OpenDome(3, 30, 10), {0.2, 1})->AddPoints({}, 0, {}, cloud);
  EXPECT_EQ(cloud.size(), 0u);
  EXPECT_GT(statistics.ray_count, 500u);
  EXPECT_EQ(statistics.odd_ray_count, statistics.ray_count);
}

TEST(Solid, ClosedSurfacesHaveNoOddLines) {
  for (const auto& mesh : {Cube(5, 7), Icosphere(3, 5, Vec3(0, 0, 0)),
                           Torus(Vec3(1, 1, 1), 3, 1, 64, 32), Cylinder(2, 3, 48)}) {
    SpacedCloud cloud;
    const auto statistics = *Solid(mesh, {0.05, 1})->AddPoints({}, 0, {}, cloud);
    EXPECT_GT(statistics.ray_count, 1000u);
    EXPECT_EQ(statistics.odd_ray_count, 0u);
  }
}

TEST(Solid, LimitsAndCancellationAreErrors) {
  const auto many = MakeSolid(Cube(900), {0.01, 1});
  ASSERT_FALSE(many.has_value());
  EXPECT_EQ(many.error().code, ErrorCode::kTooLarge);
  const auto cancelled = MakeSolid(Cube(9), {1, 1}, [](auto, auto) { return false; });
  ASSERT_FALSE(cancelled.has_value());
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(PointsOf(*Solid({}, {1, 1})).size(), 0u);
}

}  // namespace
}  // namespace intaglio::discretize
