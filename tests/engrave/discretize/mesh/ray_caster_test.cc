#include "engrave/discretize/mesh/ray_caster.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <random>

namespace intaglio::discretize {
namespace {

/// Rays and corners at whole numbers, so that as many as can be meet exactly.
RayGrid WholeNumbers(std::uint32_t count) {
  RayGrid grid;
  grid.unit_mm = 0x1p-30;
  grid.column_count = grid.row_count = count;
  return grid;
}

/// Whether ray (column, row), moved aside by (e, e^2), crosses the triangle: exact, with
/// e = 2^-20 and all coordinates times 2^40, which is small enough an e for coordinates
/// below 64.
bool Crosses(const std::array<Vec3, 3>& corner, std::uint32_t column, std::uint32_t row) {
  using Whole = __int128;
  const auto scaled = [](double x) { return static_cast<Whole>(x) * (Whole{1} << 40); };
  const Whole pu = scaled(column) + (Whole{1} << 20), pv = scaled(row) + 1;
  int positive = 0, negative = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = corner[i], &b = corner[(i + 1) % 3];
    const Whole e = (scaled(b.x()) - scaled(a.x())) * (pv - scaled(a.y())) -
                    (scaled(b.y()) - scaled(a.y())) * (pu - scaled(a.x()));
    positive += e > 0 ? 1 : 0;
    negative += e < 0 ? 1 : 0;  // neither only for corners in one place
  }
  return positive == 3 || negative == 3;
}

TEST(RayCaster, TakesTheTrianglesOfExactArithmetic) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> place(0, 12);
  const RayGrid grid = WholeNumbers(13);
  std::size_t crossings = 0;
  for (int i = 0; i < 3000; ++i) {
    std::array<Vec3, 3> corner;
    for (Vec3& p : corner) p = Vec3(place(random), place(random), place(random));
    const RayCaster caster(grid, {corner[0], corner[1], corner[2]});
    const std::vector<mesh::Triangle> triangles = {{0, 1, 2}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> found;
    const Status cast = caster.Cast(
        triangles,
        [&](std::uint32_t column, std::uint32_t row, std::span<const double> heights) {
          EXPECT_EQ(heights.size(), 1u);
          EXPECT_TRUE(found.insert({{column, row}, heights[0]}).second);
        });
    EXPECT_TRUE(cast.has_value());
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    for (std::uint32_t column = 0; column < 13; ++column) {
      for (std::uint32_t row = 0; row < 13; ++row) {
        const bool expected = Crosses(corner, column, row);
        EXPECT_EQ(found.contains({column, row}), expected);
        if (!expected || !found.contains({column, row})) continue;
        // The height in the triangle's plane; rounding of numbers of about 10.
        const Vec3 p(column, row, found[{column, row}]);
        EXPECT_NEAR((p - corner[0]).dot(normal) / normal.z(), 0, 1e-12);
        ++crossings;
      }
    }
  }
  EXPECT_GT(crossings, 10000u);
}

// A sheet of random triangles over a square, seen down its height: each ray has one.
TEST(RayCaster, ASheetIsCrossedOnceByEveryRay) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> nudge(-1, 1), height(0, 9);
  constexpr std::uint32_t kCells = 12;
  PointList corners;
  for (std::uint32_t j = 0; j <= kCells; ++j) {
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      const bool rim = i == 0 || j == 0 || i == kCells || j == kCells;
      // Whole numbers, and places that are halves of them.
      corners.emplace_back(4.0 * i + (rim ? 0 : 0.5 * nudge(random)),
                           4.0 * j + (rim ? 0 : 0.5 * nudge(random)), height(random));
    }
  }
  std::vector<mesh::Triangle> triangles;
  for (std::uint32_t j = 0; j < kCells; ++j) {
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i, d = a + kCells + 1;
      if (nudge(random) > 0) {
        triangles.push_back({a, a + 1, d + 1});
        triangles.push_back({d, a, d + 1});
      } else {
        triangles.push_back({d, a, a + 1});
        triangles.push_back({d + 1, a + 1, d});
      }
    }
  }
  const RayCaster caster(WholeNumbers(4 * kCells), corners);
  std::size_t rays = 0;
  const Status cast = caster.Cast(
      triangles, [&](std::uint32_t, std::uint32_t, std::span<const double> heights) {
        EXPECT_EQ(heights.size(), 1u);
        ++rays;
      });
  EXPECT_TRUE(cast.has_value());
  EXPECT_EQ(rays, 16u * kCells * kCells);
  // The square alone, whatever the triangles' heights.
  EXPECT_NEAR(caster.CrossingsAbout(triangles), 16.0 * kCells * kCells, 1e-9);
}

TEST(RayGrid, BetweenLiesInTheMiddles) {
  Box3 box;
  box.Extend(Vec3(1, 2, 0));
  box.Extend(Vec3(4.3, 9.1, 0));
  const RayGrid grid = GridOver(box, 0.25, 0.4).value();
  const RayGrid between = grid.Between();
  EXPECT_NEAR(between.U(1) - grid.U(0), 0.125, 1e-12);
  EXPECT_NEAR(between.V(1) - grid.V(0), 0.2, 1e-12);
  EXPECT_GE(grid.U(0), 1);
  EXPECT_LE(grid.U(grid.column_count - 1), 4.3);
  EXPECT_LE(between.U(0), 1);
  EXPECT_GE(between.U(between.column_count - 1), 4.3 - 0.25);
}

}  // namespace
}  // namespace intaglio::discretize
