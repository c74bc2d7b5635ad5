#include "engrave/proof/surface.h"

#include <gtest/gtest.h>

#include "engrave/proof/distinct_places.h"
#include "engrave/proof/surface_density.h"
#include "engrave/proof/uncovered_disc.h"
#include "tests/engrave/proof/proof_shapes.h"

namespace intaglio::proof {
namespace {

constexpr std::size_t kManyPieces = 1 << 20;

UncoveredDisc Uncovered(const mesh::TriangleMesh& model, const PointList& points_mm,
                        double piece_mm2, const Executor& executor = {}) {
  const Surface surface({model}, piece_mm2, kManyPieces);
  const PointTree tree(points_mm);
  return LargestUncoveredDisc(surface, tree, points_mm, executor);
}

/// The same by brute force over a fine grid on every triangle: never more than the true
/// value, and less by at most the grid's reach.
double SampledRadius(const mesh::TriangleMesh& model, const PointList& points_mm,
                     int steps) {
  double largest = 0;
  for (const mesh::Triangle& t : model.triangles) {
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const double u = double(i) / steps, v = double(j) / steps;
        const Vec3 at = (1 - u - v) * model.vertices[t[0]] + u * model.vertices[t[1]] +
                        v * model.vertices[t[2]];
        double smallest = INFINITY;
        for (const Vec3& p : points_mm)
          smallest = std::min(smallest, (p - at).squaredNorm());
        largest = std::max(largest, std::sqrt(smallest));
      }
    }
  }
  return largest;
}

TEST(Surface, CutsToTheAreaAndLosesNone) {
  const Surface surface({Cube(10)}, 0.7, kManyPieces);
  double area = 0;
  for (const Corners& t : surface.triangles()) {
    EXPECT_LE(AreaOf(t), 0.7);
    area += AreaOf(t);
  }
  EXPECT_NEAR(area, 600, 1e-9);
  EXPECT_EQ(Surface({Cube(10)}, 1e-9, 100).triangles().size(), 112u);
}

TEST(Surface, NearestPlaceIsThatOfBruteForce) {
  mesh::TriangleMesh soup;
  soup.vertices = RandomPoints(900, 10, 4);
  for (std::uint32_t i = 0; i < 900; i += 3) soup.triangles.push_back({i, i + 1, i + 2});
  soup.triangles.push_back({0, 0, 3});  // a line
  soup.triangles.push_back({5, 5, 5});  // a point
  const Surface surface({soup}, 1e9, 0);
  for (const Vec3& p : RandomPoints(400, 12, 5)) {
    const Surface::Place place = surface.NearestTo(p, 17);
    double smallest = INFINITY;
    for (const Corners& t : surface.triangles()) {
      smallest = std::min(smallest, (p - NearestPlaceOf(t, p)).norm());
    }
    EXPECT_EQ(std::sqrt(place.square_mm2), smallest);
    EXPECT_NEAR((p - place.at_mm).norm(), smallest, 1e-15);
  }
}

TEST(NearestPlaceOf, IsNotFartherThanAnySampledPlace) {
  const PointList random = RandomPoints(600, 3, 6);
  for (std::size_t i = 0; i + 3 < random.size(); i += 4) {
    const Corners t = {random[i], random[i + 1], random[i + 2]};
    const Vec3& p = random[i + 3];
    const double found = (p - NearestPlaceOf(t, p)).norm();
    double sampled = INFINITY;
    for (int a = 0; a <= 60; ++a) {
      for (int b = 0; a + b <= 60; ++b) {
        const Vec3 at = t[0] + a / 60.0 * (t[1] - t[0]) + b / 60.0 * (t[2] - t[0]);
        sampled = std::min(sampled, (p - at).norm());
      }
    }
    EXPECT_LE(found, sampled + 1e-12);
    // The sampled place is at most a step of the grid away from the nearest one.
    EXPECT_GE(found, sampled - 3 * std::sqrt(3.0) / 30);
  }
}

// Around every point of the hexagonal lattice the holes lie at spacing / sqrt 3.
TEST(UncoveredDisc, OfTheHexagonalLattice) {
  const PointList points = HexagonalLattice(12, 7, 3, 0.4);
  for (const std::uint32_t cells : {1u, 40u}) {
    const UncoveredDisc disc =
        Uncovered(Rectangle(12, 7, 3, cells), points, cells == 1 ? 1e9 : 0.02);
    EXPECT_NEAR(disc.radius_mm, 0.4 / std::sqrt(3.0), 1e-12);
    EXPECT_GE(disc.upper_bound_mm, disc.radius_mm);
    EXPECT_LE(disc.upper_bound_mm, disc.radius_mm * 1.001);
    EXPECT_NEAR(disc.place_mm.z(), 3, 1e-12);
  }
}

// The widest hole of a square lattice is in the middle of four points; when one is taken
// away, it is where that point was.
TEST(UncoveredDisc, OfTheSquareLatticeAndOfOneThatLacksAPoint) {
  PointList points;
  for (int i = 0; i <= 30; ++i) {
    for (int j = 0; j <= 30; ++j) points.emplace_back(0.5 * i, 0.5 * j, 1);
  }
  const auto surface = Rectangle(15, 15, 1, 7);
  EXPECT_NEAR(Uncovered(surface, points, 0.3).radius_mm, std::sqrt(0.125), 1e-12);
  const auto lost = points.begin() + 31 * 11 + 17;
  const Vec3 hole = *lost;
  points.erase(lost);
  const UncoveredDisc disc = Uncovered(surface, points, 0.3);
  EXPECT_NEAR(disc.radius_mm, 0.5, 1e-12);
  EXPECT_NEAR((disc.place_mm - hole).norm(), 0, 1e-12);
}

// A face without points: the farthest place of the cube's lid from points on its rim,
// here its middle.
TEST(UncoveredDisc, FindsALostFace) {
  PointList points;
  for (int i = 0; i <= 200; ++i) {
    for (int k = 0; k <= 200; ++k) {
      const double a = 0.05 * i, z = 0.05 * k;
      points.emplace_back(a, 0, z);
      points.emplace_back(a, 10, z);
      points.emplace_back(0, a, z);
      points.emplace_back(10, a, z);
      points.emplace_back(a, z, 0);
    }
  }
  const UncoveredDisc disc = Uncovered(Cube(10), DistinctPlacesOf(points).places_mm, 0.1);
  // 800 points of the rim are nearly equally far: a thousandth is all that is promised.
  EXPECT_NEAR(disc.radius_mm, 5, 0.005);
  EXPECT_GE(disc.upper_bound_mm, 5);
  EXPECT_LE(disc.upper_bound_mm, 1.001 * disc.radius_mm);
  EXPECT_NEAR((disc.place_mm - Vec3(5, 5, 10)).norm(), 0, 0.01);
}

TEST(UncoveredDisc, EqualsSamplingOfRandomClouds) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const PointList points = RandomPoints(60, 4, seed);
    const auto model = Cube(4);
    const UncoveredDisc disc = Uncovered(model, points, 1.0);
    const double sampled = SampledRadius(model, points, 100);
    EXPECT_GE(disc.upper_bound_mm, sampled - 1e-12);
    // The grid's places are 0.04 x 0.04 apart on faces of right triangles.
    EXPECT_LE(disc.radius_mm, sampled + 0.04);
    double smallest = INFINITY;
    for (const Vec3& p : points)
      smallest = std::min(smallest, (p - disc.place_mm).norm());
    EXPECT_NEAR(smallest, disc.radius_mm, 1e-12);
    const UncoveredDisc scattered = Uncovered(model, points, 1.0, Scattered());
    EXPECT_EQ(scattered.radius_mm, disc.radius_mm);
    EXPECT_EQ(scattered.place_mm, disc.place_mm);
  }
}

// All points of a sphere are equally far from its middle: no cutting into cells helps.
TEST(UncoveredDisc, BoundsAPlaceThatThousandsOfPointsAreEquallyFarFrom) {
  PointList points;
  for (int i = 0; i < 4000; ++i) {
    const double z = 1 - (i + 0.5) / 2000, turn = 2.399963 * i;
    const double r = std::sqrt(1 - z * z);
    points.push_back(Vec3(5, 5, 2) + 3 * Vec3(r * std::cos(turn), r * std::sin(turn), z));
  }
  auto model = Rectangle(2, 2, 2, 1);
  for (Vec3& v : model.vertices) v += Vec3(4.1, 4.2, 0);
  const UncoveredDisc disc = Uncovered(model, points, 1.0);
  EXPECT_NEAR(disc.radius_mm, 3, 0.003);
  EXPECT_GE(disc.upper_bound_mm, disc.radius_mm);
  EXPECT_LE(disc.upper_bound_mm, 1.001 * disc.radius_mm);
}

SurfaceDensity Density(const mesh::TriangleMesh& model, const PointList& points_mm,
                       const SurfaceDensityOptions& options) {
  const Surface surface({model}, PieceArea(600, points_mm.size(), options), kManyPieces);
  return MeasureSurfaceDensity(surface, points_mm, options);
}

TEST(SurfaceDensity, FindsThePointOffTheCube) {
  PointList points = {Vec3(1, 1, 0), Vec3(10, 4, 4), Vec3(3, 3, 10.02)};
  // Beyond a corner the distance is that to the corner; inside that to the nearest face.
  points.push_back(Vec3(10, 10, 10) + Vec3(0.3, 0.4, 1.2));
  points.push_back(Vec3(5, 5, 1.1));
  const SurfaceDensity density = Density(Cube(10), points, {.reach_mm = 0.05});
  EXPECT_NEAR(density.area_mm2, 600, 1e-9);
  EXPECT_NEAR(density.greatest_distance_mm, 1.3, 1e-12);
  EXPECT_EQ(density.farthest_point, 3u);
  EXPECT_EQ(density.on_surface_count, 3u);
  EXPECT_NEAR(density.greatest_on_surface_mm, 0.02, 1e-12);
  EXPECT_NEAR(density.points_per_mm2, 3.0 / 600, 1e-12);
}

PointList OnTheCube(int count, bool crowded) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> coordinate(0, 10);
  PointList points;
  for (int i = 0; i < count; ++i) {
    Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    const int face = crowded && i % 2 == 0 ? 0 : i % 6;
    p[face / 2] = face % 2 == 0 ? 0 : 10;
    points.push_back(p);
  }
  return points;
}

TEST(SurfaceDensity, OfALatticeIsEvenOfRandomPointsAsPoissonAndOfCrowdsMore) {
  const SurfaceDensityOptions options{.reach_mm = 0.01, .points_per_patch = 100};
  PointList lattice;
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      for (int face = 0; face < 6; ++face) {
        Vec3 p;
        p[face / 2] = face % 2 == 0 ? 0 : 10;
        p[(face / 2 + 1) % 3] = 0.1 * i + 0.05;
        p[(face / 2 + 2) % 3] = 0.1 * j + 0.05;
        lattice.push_back(p);
      }
    }
  }
  const SurfaceDensity even = Density(Cube(10), lattice, options);
  EXPECT_NEAR(even.points_per_mm2, 100, 1e-9);
  EXPECT_EQ(even.patch_count, 600u);
  EXPECT_LT(even.variation_ratio, 0.07);  // the patches' rims cut through the lattice
  EXPECT_EQ(even.empty_patch_count, 0u);
  // Poisson: 1 / sqrt(100), known from 600 patches to 3 % (1 / sqrt(2 n)); patches are
  // equal to 1/16 of an area, which adds little.
  const SurfaceDensity random = Density(Cube(10), OnTheCube(60000, false), options);
  EXPECT_NEAR(random.variation_ratio, 0.1, 0.01);
  // Densities of the faces 3, 1, 1, 1, 0, 0: 1, less for patches that bend around edges.
  const SurfaceDensity crowded = Density(Cube(10), OnTheCube(60000, true), options);
  EXPECT_NEAR(crowded.variation_ratio, 1, 0.1);
  const SurfaceDensity scattered =
      Density(Cube(10), lattice, {.reach_mm = 0.01, .executor = Scattered()});
  EXPECT_EQ(scattered.variation_ratio, even.variation_ratio);
}

}  // namespace
}  // namespace intaglio::proof
