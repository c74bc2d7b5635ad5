#include "engrave/discretize/rays.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

MethodStatistics Cast(const mesh::TriangleMesh& mesh, double distance_mm,
                      PointCloud& cloud, const Direction& direction = {}) {
  const auto statistics = CrossRays(mesh, {distance_mm, direction}, 0, {}, cloud);
  EXPECT_TRUE(statistics.has_value());
  return *statistics;
}

// The grid's rays go exactly through the corners, edges and diagonals of the cube.
TEST(Rays, ThroughEdgesAndVerticesCountOnce) {
  for (const double step : {0.25, 0.5, 1.0}) {
    PointCloud cloud;
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
      PointCloud cloud;
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
  PointCloud cloud;
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
  PointCloud cloud;
  Cast(mesh, 0.5, cloud, {Axis::kY, Vec3(0.2, 0.3, 0.4)});
  ASSERT_GT(cloud.size(), 100u);
  // Near the rim rays graze the triangles, which magnifies rounding.
  for (const Vec3& p : cloud.points_mm) EXPECT_LT(DistanceToMesh(p, mesh), 1e-9);
}

TEST(Rays, TooFineAGridIsAnError) {
  PointCloud cloud;
  const auto result =
      CrossRays(Cuboid(Vec3(0, 0, 0), Vec3(1000, 1000, 1)), {0.01, {}}, 0, {}, cloud);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::discretize
