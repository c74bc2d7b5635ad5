#include "engrave/discretize/fill.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engrave/discretize/weld.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

PointCloud Filled(const mesh::TriangleMesh& mesh, double distance_mm, bool full = true) {
  PointCloud cloud;
  const auto statistics = FillTriangles(mesh, {distance_mm, full}, 2, {}, cloud);
  EXPECT_TRUE(statistics.has_value());
  EXPECT_EQ(statistics->point_count, cloud.size());
  return cloud;
}

TEST(Fill, CandidatesLieOnTheSurface) {
  const auto mesh = Icosphere(5, 2, Vec3(1, 2, 3));
  const PointCloud cloud = Filled(mesh, 0.5);
  ASSERT_GT(cloud.size(), 1000u);
  // Rounding of coordinates of about 8 mm.
  EXPECT_LT(LargestDistanceToMesh(cloud.points_mm, mesh), 1e-14 * 100);
  for (const std::uint32_t source : cloud.source) EXPECT_EQ(source, 2u);
}

// Whether the triangles are larger than the spacing, of its size, or far smaller, no
// place of the surface is left bare: 1.36 spacings by the derivation in fill.cc, and for
// triangles smaller than a point their size is added.
TEST(Fill, AWeldedFillCoversTrianglesOfEverySize) {
  const double spacing = 0.4;
  for (const int level : {0, 2, 4, 5}) {
    const auto mesh = Icosphere(4, level, Vec3(0, 0, 0));
    const PointCloud kept = WeldToSpacing(Filled(mesh, spacing), spacing);
    EXPECT_GE(LeastDistance(kept.points_mm), spacing * (1 - 1e-15));
    EXPECT_LT(LargestGap(mesh, kept.points_mm, 0.05), 1.5 * spacing) << level;
  }
}

TEST(Fill, SplintersAreCovered) {
  MeshBuilder builder;
  for (int i = 0; i < 200; ++i) {
    const double y = 0.01 * i;
    builder.AddQuad(Vec3(0, y, 0), Vec3(10, y, 0), Vec3(10, y + 0.01, 0),
                    Vec3(0, y + 0.01, 0));
  }
  const auto mesh = builder.Take();
  const PointCloud kept = WeldToSpacing(Filled(mesh, 0.3), 0.3);
  EXPECT_LT(LargestGap(mesh, kept.points_mm, 0.05), 1.36 * 0.3);
}

TEST(Fill, FullFillShowsCornersAndEdges) {
  const auto cube = Cuboid(Vec3(0, 0, 0), Vec3(2, 2, 2));
  const auto on_edge = [](const Vec3& p) {
    int walls = 0;
    for (int axis = 0; axis < 3; ++axis) walls += p[axis] == 0 || p[axis] == 2;
    return walls >= 2;
  };
  const PointCloud full = Filled(cube, 0.25), open = Filled(cube, 0.25, false);
  EXPECT_EQ(std::count_if(open.points_mm.begin(), open.points_mm.end(), on_edge), 0);
  const PointCloud welded = WeldToSpacing(full, 1e-9);
  // Lines across the height of sqrt(2) mm at most 0.125 mm apart: each edge has 12 parts.
  EXPECT_EQ(std::count_if(welded.points_mm.begin(), welded.points_mm.end(), on_edge),
            12 * 11 + 8);
  for (const Vec3& corner : cube.vertices) {
    EXPECT_NE(std::find(full.points_mm.begin(), full.points_mm.end(), corner),
              full.points_mm.end());
  }
}

TEST(Fill, TrianglesSmallerThanAPointGiveTheirCentre) {
  const auto mesh = Icosphere(1, 3, Vec3(0, 0, 0));
  PointCloud cloud;
  const auto statistics = FillTriangles(mesh, {2, true}, 0, {}, cloud);
  ASSERT_TRUE(statistics.has_value());
  EXPECT_EQ(statistics->small_triangle_count, mesh.triangles.size());
  EXPECT_EQ(cloud.size(), mesh.triangles.size());
}

TEST(Fill, TrianglesWithoutAreaAreCountedAndLeftOut) {
  mesh::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 3}, {0, 1, 3}};
  PointCloud cloud;
  const auto statistics = FillTriangles(mesh, {0.5, true}, 0, {}, cloud);
  ASSERT_TRUE(statistics.has_value());
  EXPECT_EQ(statistics->rejected_triangle_count, 2u);
}

TEST(Fill, TooManyCandidatesAreAnErrorAtOnce) {
  PointCloud cloud;
  const auto result = FillTriangles(Cuboid(Vec3(0, 0, 0), Vec3(900, 900, 900)),
                                    {0.01, true}, 0, {}, cloud);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(cloud.size(), 0u);
}

}  // namespace
}  // namespace intaglio::discretize
