#include "engrave/discretize/mesh/rays.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/source_checks.h"

namespace intaglio::discretize {
namespace {

MethodStatistics Cast(const mesh::TriangleMesh& mesh, double distance_mm,
                      SpacedCloud& cloud, const Direction& direction = {}) {
  const auto source = MakeRays(mesh, {distance_mm, direction});
  EXPECT_TRUE(source.has_value());
  const auto statistics = (*source)->AddPoints({}, 0, {}, cloud);
  EXPECT_TRUE(statistics.has_value());
  return *statistics;
}

// The grid's rays go exactly through the corners, edges and diagonals of the cube.
TEST(Rays, ThroughEdgesAndVerticesCountOnce) {
  for (const double step : {0.25, 0.5, 1.0}) {
    SpacedCloud cloud;
    const auto cube = Cuboid(Vec3(0, 0, 0), Vec3(1, 1, 1) / kRoundingAllowance);
    const auto scaled = [&] {
      auto mesh = cube;
      for (Vec3& v : mesh.vertices) v *= kRoundingAllowance;
      return mesh;
    }();
    const auto statistics = Cast(scaled, step, cloud);
    EXPECT_EQ(statistics.odd_ray_count, 0u);
    EXPECT_EQ(statistics.point_count, 2 * statistics.ray_count);
  }
}

TEST(Rays, EveryRayCrossesAClosedSurfaceAnEvenNumberOfTimes) {
  const Direction oblique{Axis::kX, Vec3(0.4, 0.2, -0.9)};
  for (const auto& mesh :
       {Torus(Vec3(0, 0, 0), 5, 2, 24, 16), Sphere(Vec3(1, 1, 1), 4, 16, 24)}) {
    for (const Direction& direction : {Direction{}, oblique}) {
      SpacedCloud cloud;
      const auto statistics = Cast(mesh, 0.05, cloud, direction);
      EXPECT_GT(statistics.ray_count, 1000u);
      EXPECT_EQ(statistics.odd_ray_count, 0u);
    }
  }
}

// Independent oracle: Moeller and Trumbore's test of every triangle, for rays in general
// position.
TEST(Rays, CountsAreThoseOfBruteForce) {
  const auto mesh = Torus(Vec3(0.123, -0.0417, 0.3), 5, 2, 24, 16);
  const Direction direction{Axis::kZ, Vec3(0.31, 0.17, 0.05)};
  SpacedCloud cloud;
  Cast(mesh, 0.37, cloud, direction);
  const Vec3 w = FrameOf(direction).col(2);
  std::size_t expected = 0;
  PointList bases;
  for (const Vec3& p : cloud.points_mm) {
    const Vec3 base = p - p.dot(w) * w;
    const bool known = std::any_of(bases.begin(), bases.end(), [&](const Vec3& b) {
      return (b - base).norm() < 1e-9;
    });
    if (!known) bases.push_back(base);
  }
  for (const Vec3& base : bases) {
    for (const mesh::Triangle& t : mesh.triangles) {
      const Vec3 e1 = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      const Vec3 e2 = mesh.vertices[t[2]] - mesh.vertices[t[0]];
      const Vec3 s = base - mesh.vertices[t[0]];
      const double det = w.cross(e2).dot(e1);
      if (det == 0) continue;
      const double u = w.cross(e2).dot(s) / det, v = s.cross(e1).dot(w) / det;
      if (u >= 0 && v >= 0 && u + v <= 1) ++expected;
    }
  }
  EXPECT_EQ(cloud.size(), expected);
}

TEST(Rays, CrossingsLieOnTheSurface) {
  const auto mesh = Torus(Vec3(1, 2, 3), 5, 2, 24, 16);
  SpacedCloud cloud;
  Cast(mesh, 0.5, cloud, {Axis::kY, Vec3(0.2, 0.3, 0.4)});
  ASSERT_GT(cloud.size(), 100u);
  // Near the rim rays graze the triangles, which magnifies rounding.
  for (const Vec3& p : cloud.points_mm) EXPECT_LT(DistanceToMesh(p, mesh), 1e-9);
}

TEST(Rays, TooFineAGridIsAnError) {
  const auto result = MakeRays(Cuboid(Vec3(0, 0, 0), Vec3(1000, 1000, 1)), {0.01, {}});
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kTooLarge);
}

// The distance of the grid's rays over a model of this size, found from the hits.
double PitchMm(double size_mm, double distance_mm) {
  SpacedCloud cloud;
  Cast(Cube(size_mm), distance_mm, cloud);
  double pitch_mm = INFINITY;
  for (const Vec3& p : cloud.points_mm) {
    const double apart_mm = p.y() - cloud.points_mm.front().y();
    if (apart_mm > 0) pitch_mm = std::min(pitch_mm, apart_mm);
  }
  return pitch_mm;
}

// Vertices, edges and diagonals of all cells of the faces lie exactly on rays.
TEST(Rays, EveryRayThroughAVertexOfADividedCubeCountsOnce) {
  for (const double distance_mm : {0.25, 0.1, 1.0 / 3}) {
    const int cells = 12;
    mesh::TriangleMesh cube = Cube(cells, cells);
    for (Vec3& v : cube.vertices) v *= PitchMm(cells * distance_mm, distance_mm);
    for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) {
      SpacedCloud cloud;
      const auto statistics = Cast(cube, distance_mm, cloud, {axis, Vec3::Zero()});
      EXPECT_EQ(statistics.odd_ray_count, 0u);
      // Those of the 13 x 13 rays on two of the four sides pass outside.
      EXPECT_EQ(statistics.ray_count, 144u) << distance_mm;
      EXPECT_EQ(statistics.point_count, 288u);
    }
  }
}

// A wall of splinters of every size, down to below the resolution of the grid, seen
// aslant and edge-on.
TEST(Rays, SplintersAndTinyTrianglesKeepTheParity) {
  const auto make = [](double squeeze) {
    auto mesh = Icosphere(5, 4, Vec3(0, 0, 0));
    for (Vec3& v : mesh.vertices) v.x() *= squeeze;
    return mesh;
  };
  for (const double squeeze : {1.0, 1e-3, 1e-7, 1e-11}) {
    const auto mesh = make(squeeze);
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      for (const double turn : {0.0, 1e-9, 0.3}) {
        SpacedCloud cloud;
        const auto statistics = Cast(mesh, 0.1, cloud, {axis, Vec3(0, turn, turn)});
        EXPECT_EQ(statistics.odd_ray_count, 0u) << squeeze << " " << turn;
      }
    }
  }
}

TEST(Rays, CrossingsOfSplintersLieOnTheSurface) {
  auto mesh = Icosphere(5, 3, Vec3(0, 0, 0));
  for (Vec3& v : mesh.vertices) v.x() *= 1e-5;
  SpacedCloud cloud;
  Cast(mesh, 0.2, cloud, {Axis::kZ, Vec3(0, 1e-6, 0)});
  Cast(mesh, 0.2, cloud, {Axis::kY, Vec3(0.2, 0.1, 0)});
  ASSERT_GT(cloud.size(), 10u);
  // 1e-10 mm is what rays.cc derives for slender triangles.
  EXPECT_LT(LargestDistanceToMesh(cloud.points_mm, mesh), 1e-10);
}

// Every ray of the grid, met or not, against Moeller and Trumbore.
TEST(Rays, NoRayIsForgotten) {
  const auto mesh = Torus(Vec3(0.123, -0.0417, 0.3), 5, 2, 24, 16);
  const double distance_mm = 0.41;
  SpacedCloud cloud;
  Cast(mesh, distance_mm, cloud);
  std::map<std::pair<double, double>, int> found;
  for (const Vec3& p : cloud.points_mm) ++found[{p.x(), p.y()}];
  const Vec3 first = cloud.points_mm.front();
  const double pitch = PitchMm(7, distance_mm);
  int met = 0;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      const Vec3 origin = first + Vec3(i, j, 0) * pitch;
      bool clear = false;
      const int expected = CrossingsOfLine(mesh, origin, Vec3::UnitZ(), clear);
      if (!clear) continue;
      // The sums of steps that lead to a ray may differ in their last digits.
      int count = 0;
      for (const auto& [at, hits] : found) {
        if (std::hypot(at.first - origin.x(), at.second - origin.y()) < 1e-9)
          count += hits;
      }
      EXPECT_EQ(count, expected);
      if (expected > 0) ++met;
    }
  }
  EXPECT_GT(met, 300);
}

TEST(Rays, CrossingsOfASphereAreAtItsDepths) {
  const Vec3 centre(1, 2, 3);
  SpacedCloud cloud;
  const auto statistics = Cast(Icosphere(5, 5, centre), 0.2, cloud);
  // Facets of 2 degrees lie at most R (1 - cos 1.5 deg) inside the sphere.
  for (const Vec3& p : cloud.points_mm) EXPECT_NEAR((p - centre).norm(), 5, 2e-3);
  // The disc of radius 5 is met by its area's worth of rays, but for those at its rim.
  EXPECT_NEAR(static_cast<double>(statistics.ray_count), std::numbers::pi * 25 / 0.04,
              2 * std::numbers::pi * 5 / 0.2);
}

TEST(Rays, SlabsAreTheWhole) {
  auto torus = Torus(Vec3(5, 6, 7), 3, 1, 24, 16);
  torus.triangles.erase(torus.triangles.begin() + 100, torus.triangles.begin() + 120);
  for (const bool interior_only : {false, true}) {
    for (const Direction& direction :
         {Direction{}, Direction{Axis::kX, Vec3::Zero()},
          Direction{Axis::kZ, Vec3(0.3, 0.2, 0)}, Direction{Axis::kY, Vec3(0, 1, 2)}}) {
      const auto source = MakeRays(torus, {0.1, direction, interior_only});
      ExpectSlabsAreTheWhole(**source, {6, 6.05, 6.0500001, 7, 7.3, 7.9});
      ExpectSlabsAreTheWhole(**source, {(*source)->Bounds().min_mm.z()});
    }
  }
}

TEST(Rays, InsideOfASphereIsFilledEvenly) {
  const Vec3 centre(5, 5, 5);
  const double radius = 3, distance = 0.2;
  const Direction direction{Axis::kZ, Vec3(0.3, 0.2, 0)};
  const auto source = MakeRays(Icosphere(radius, 4, centre), {distance, direction, true});
  SpacedCloud cloud;
  const auto statistics = (*source)->AddPoints({}, 0, {}, cloud).value();
  EXPECT_EQ(statistics.odd_ray_count, 0u);
  const Vec3 w = FrameOf(direction).col(2);
  for (const Vec3& p : cloud.points_mm) {
    // The way along the ray to the sphere; facets of 4 degrees lie 5 um within it.
    const double along = (p - centre).dot(w);
    const double aside = ((p - centre) - along * w).squaredNorm();
    EXPECT_GT(std::sqrt(radius * radius - aside) - std::abs(along), distance - 0.05);
  }
  EXPECT_GE(MinDistance(cloud.points_mm), distance);
  // As many as there are cells of 0.2 mm, less those of one at either end of each ray and
  // those that do not fit.
  const double cells = 4.0 / 3 * std::numbers::pi * std::pow(radius / distance, 3);
  const double rays = std::numbers::pi * std::pow(radius / distance, 2);
  EXPECT_LT(static_cast<double>(cloud.size()), cells - rays);
  EXPECT_GT(static_cast<double>(cloud.size()), cells - 2.2 * rays);
}

TEST(Rays, AGridThroughTheOriginIsTheSameForAllModels) {
  const auto cloud_of = [](const mesh::TriangleMesh& mesh, const RayOptions& options) {
    SpacedCloud cloud;
    const auto source = MakeRays(mesh, options);
    EXPECT_TRUE(source.has_value());
    EXPECT_TRUE((*source)->AddPoints({}, 0, {}, cloud).has_value());
    return cloud.points_mm;
  };
  RayOptions options;
  options.distance_mm = 0.5;
  options.grid_through_origin = true;
  for (const auto& ball :
       {Icosphere(2, 4, Vec3(5.1, 5.2, 5)), Icosphere(1.3, 4, Vec3(-7.3, 2.2, 1))}) {
    const PointList points = cloud_of(ball, options);
    EXPECT_GT(points.size(), 20u);
    for (const Vec3& p : points) {
      // A step is longer by 1e-9 (kRoundingAllowance).
      EXPECT_NEAR(std::remainder(p.x(), 0.5), 0, 1e-7);
      EXPECT_NEAR(std::remainder(p.y(), 0.5), 0, 1e-7);
    }
    options.grid_through_origin = false;
    EXPECT_GT(std::abs(std::remainder(cloud_of(ball, options)[0].x(), 0.5)), 1e-3);
    options.grid_through_origin = true;
  }
  // Between two rays.
  EXPECT_TRUE(cloud_of(Icosphere(0.2, 3, Vec3(0.25, 0.25, 1)), options).empty());
}

TEST(Rays, ADirectionInTheModelsAxesIsTheOneTurned) {
  const auto torus = Torus(Vec3(5, 6, 7), 3, 1, 24, 16);
  RayOptions of_model{.distance_mm = 0.2, .direction = {Axis::kX, Vec3::Zero()}};
  of_model.axes = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
  const RayOptions of_block{.distance_mm = 0.2, .direction = {Axis::kX, Vec3(0, 0, 0.4)}};
  SpacedCloud by_model, by_block;
  (void)MakeRays(torus, of_model).value()->AddPoints({}, 0, {}, by_model);
  (void)MakeRays(torus, of_block).value()->AddPoints({}, 0, {}, by_block);
  ASSERT_EQ(by_model.size(), by_block.size());
  for (std::size_t i = 0; i < by_model.size(); ++i)
    EXPECT_LT((by_model.points_mm[i] - by_block.points_mm[i]).norm(), 1e-9);
}

TEST(Rays, OpenPlacesHaveNoInside) {
  const auto source = MakeRays(OpenDome(5, 64, 16), {0.25, {}, true});
  SpacedCloud cloud;
  const auto statistics = (*source)->AddPoints({}, 0, {}, cloud).value();
  EXPECT_EQ(statistics.odd_ray_count, statistics.ray_count);
  EXPECT_GT(statistics.ray_count, 1000u);
  EXPECT_EQ(cloud.size(), 0u);
}

TEST(Rays, ProgressCanEndIt) {
  for (const bool interior_only : {false, true}) {
    const auto source = MakeRays(Cube(1), {0.1, {}, interior_only});
    SpacedCloud cloud;
    const auto result = (*source)->AddPoints(
        {}, 0, [](std::uint64_t, std::uint64_t) { return false; }, cloud);
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kCancelled);
  }
}

TEST(Rays, NothingComesOfAnEmptyMesh) {
  SpacedCloud cloud;
  EXPECT_EQ(Cast({}, 1, cloud).ray_count, 0u);
}

}  // namespace
}  // namespace intaglio::discretize
