#include "engrave/discretize/mesh/fill.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/surface_checks.h"

namespace intaglio::discretize {
namespace {

std::unique_ptr<PointSource> Fill(const mesh::TriangleMesh& mesh, double distance_mm,
                                  bool full = true) {
  auto source = MakeFill(mesh, {distance_mm, full});
  EXPECT_TRUE(source.has_value());
  return *std::move(source);
}

TEST(Fill, CandidatesLieOnTheSurface) {
  const auto mesh = Icosphere(5, 2, Vec3(1, 2, 3));
  const SpacedCloud cloud = PointsOf(*Fill(mesh, 0.8));
  ASSERT_GT(cloud.size(), 1000u);
  // Rounding of coordinates of about 8 mm.
  EXPECT_LT(LargestDistanceToMesh(cloud.points_mm, mesh), 1e-13);
  for (const std::uint32_t source : cloud.source) EXPECT_EQ(source, 2u);
}

// Whether the triangles are larger than the spacing, of its size, or far smaller.
TEST(Fill, AThinnedFillIsEvenOnTrianglesOfEverySize) {
  const double spacing = 0.4;
  for (const int level : {0, 2, 4, 5}) {
    const auto mesh = Icosphere(4, level, Vec3(0, 0, 0));
    for (const bool full : {true, false}) {
      const SpacedCloud kept = Thinned(*Fill(mesh, spacing, full));
      const Evenness even = EvennessOf(kept.points_mm);
      EXPECT_GE(even.smallest, spacing * (1 - 1e-7)) << level;
      EXPECT_LE(even.variation, 0.05) << level;
      EXPECT_LE(LargestGap(mesh, kept.points_mm, 0.05), 1.2 * spacing) << level;
    }
  }
}

TEST(Fill, SplintersAreCoveredAndNotCrowded) {
  MeshBuilder builder;
  for (int i = 0; i < 200; ++i) {
    const double y = 0.01 * i;
    builder.AddQuad(Vec3(0, y, 0), Vec3(10, y, 0), Vec3(10, y + 0.01, 0),
                    Vec3(0, y + 0.01, 0));
  }
  const auto mesh = builder.Take();
  const auto source = Fill(mesh, 0.3);
  // 20 mm^2 in squares of 0.3 mm, 16 / 0.87 nodes each; edges' points no more than one
  // for each cube of 0.075 mm, which the plane cuts 16 a square.
  EXPECT_LT(PointsOf(*source).size(), 20 / 0.09 * (16 / 0.87 + 16) * 1.1);
  EXPECT_LT(LargestGap(mesh, Thinned(*source).points_mm, 0.05), 1.2 * 0.3);
}

TEST(Fill, FullFillShowsCornersAndEdges) {
  const auto cube = Cuboid(Vec3(0, 0, 0), Vec3(2, 2, 2));
  const auto on_edge = [](const Vec3& p) {
    int walls = 0;
    for (int axis = 0; axis < 3; ++axis) walls += p[axis] == 0 || p[axis] == 2;
    return walls >= 2;
  };
  const SpacedCloud full = PointsOf(*Fill(cube, 0.25)),
                    open = PointsOf(*Fill(cube, 0.25, false));
  EXPECT_EQ(std::count_if(open.points_mm.begin(), open.points_mm.end(), on_edge), 0);
  // Each edge of 2 mm in 32 parts or more, of which a cube of the step may hold two.
  EXPECT_GT(std::count_if(full.points_mm.begin(), full.points_mm.end(), on_edge),
            12 * 25);
  for (const Vec3& corner : cube.vertices) {
    EXPECT_NE(std::find(full.points_mm.begin(), full.points_mm.end(), corner),
              full.points_mm.end());
  }
}

TEST(Fill, TrianglesSmallerThanAPointShareTheirPoints) {
  const auto mesh = Icosphere(1, 4, Vec3(0, 0, 0));
  SpacedCloud cloud;
  const auto source = Fill(mesh, 2);
  const auto statistics = *source->AddPoints({}, 0, {}, cloud);
  EXPECT_EQ(statistics.small_triangle_count, mesh.triangles.size());
  EXPECT_LT(cloud.size(), mesh.triangles.size() / 10);
  EXPECT_LT(LargestGap(mesh, Thinned(*source).points_mm, 0.1), 1.2 * 2);
}

TEST(Fill, TrianglesWithoutAreaAreCountedAndLeftOut) {
  mesh::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 3}, {0, 1, 3}};
  SpacedCloud cloud;
  const auto statistics = *Fill(mesh, 0.5)->AddPoints({}, 0, {}, cloud);
  EXPECT_EQ(statistics.rejected_triangle_count, 2u);
}

TEST(Fill, IsTheSameInEveryCutByHeight) {
  for (const bool full : {true, false}) {
    ExpectSameInRanges(*Fill(Cube(3), 0.3, full), {0, 1, 1.1, 3});
    ExpectSameInRanges(*Fill(Icosphere(2, 5, Vec3(1, 2, 3)), 0.3, full), {2, 3});
  }
}

TEST(Fill, TooManyCandidatesAreAnErrorAtOnce) {
  SpacedCloud cloud;
  const auto result =
      Fill(Cuboid(Vec3(0, 0, 0), Vec3(900, 900, 900)), 0.01)->AddPoints({}, 0, {}, cloud);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kTooLarge);
  EXPECT_LT(cloud.size(), 1000u);
}

}  // namespace
}  // namespace intaglio::discretize
