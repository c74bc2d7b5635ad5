#include "engrave/proof/height_slices.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/proof/cloud_quality.h"
#include "tests/engrave/proof/proof_shapes.h"

namespace intaglio::proof {
namespace {

/// Slices of a sphere of equal thickness have equal areas (Archimedes): as fine as
/// this its mesh comes near that.
mesh::TriangleMesh Globe(double radius_mm) {
  constexpr std::uint32_t kRings = 200, kSides = 200;
  mesh::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= kRings; ++j) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double down = std::numbers::pi * j / kRings;
      const double around = 2 * std::numbers::pi * i / kSides;
      mesh.vertices.push_back(radius_mm * Vec3(std::sin(down) * std::cos(around),
                                               std::sin(down) * std::sin(around),
                                               std::cos(down)));
    }
  }
  for (std::uint32_t j = 0; j < kRings; ++j) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = j * kSides + i, b = j * kSides + (i + 1) % kSides;
      mesh.triangles.push_back({a, a + kSides, b});
      mesh.triangles.push_back({b, a + kSides, b + kSides});
    }
  }
  return mesh;
}

/// Equally many points at each height.
PointList Spiral(double radius_mm, int count, double gap_low_mm, double gap_high_mm) {
  PointList points;
  for (int i = 0; i < count; ++i) {
    const double z = radius_mm * (-1 + 2 * (i + 0.5) / count);
    if (z > gap_low_mm && z < gap_high_mm) continue;
    const double across = std::sqrt(radius_mm * radius_mm - z * z);
    const double turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    points.emplace_back(across * std::cos(turn), across * std::sin(turn), z);
  }
  return points;
}

TEST(HeightSlices, OfAGlobeEachHasTheSameShareOfThePoints) {
  const HeightSlices slices =
      MeasureHeightSlices({Globe(5)}, Spiral(5, 20000, 9, 9), 0.05);
  EXPECT_EQ(slices.slice_count, 200u);
  EXPECT_EQ(slices.band_count, 0u);
  EXPECT_NEAR(slices.smallest_ratio, 1, 0.03);
}

TEST(HeightSlices, ABandIsFoundWhereItIs) {
  const HeightSlices slices =
      MeasureHeightSlices({Globe(5)}, Spiral(5, 20000, 1.0, 1.09), 0.05);
  EXPECT_EQ(slices.band_count, 2u);
  EXPECT_LT(slices.smallest_ratio, 0.02);
  EXPECT_NEAR(slices.smallest_low_mm, 1.0, 1e-9);
}

TEST(HeightSlices, TrianglesOfEveryAttitudeCountByTheirArea) {
  // Upright, with the middle corner at either end, and a level one.
  mesh::TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(8, 0, 0), Vec3(0, 0, 8),
                   Vec3(8, 0, 8), Vec3(0, 8, 0), Vec3(3, 0, 5)};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {0, 1, 4}, {0, 1, 5}, {5, 3, 2}};
  PointList points;
  const double step_mm = 0.05;
  for (const mesh::Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]], u = mesh.vertices[t[1]] - a,
               v = mesh.vertices[t[2]] - a;
    const double area_mm2 = 0.5 * u.cross(v).norm();
    const int n = static_cast<int>(std::sqrt(2 * area_mm2) / step_mm);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j + i < n; ++j) {
        points.push_back(a + u * (i + 1.0 / 3) / n + v * (j + 1.0 / 3) / n);
      }
    }
  }
  const HeightSlices slices = MeasureHeightSlices({mesh}, points, 0.8);
  // Ten of the height of 8 mm, without the three at the level face.
  EXPECT_EQ(slices.slice_count, 7u);
  EXPECT_NEAR(slices.smallest_ratio, 1, 0.1);
}

TEST(HeightSlices, AFewPointsOrNoneGiveNoFigure) {
  EXPECT_EQ(MeasureHeightSlices({Globe(5)}, Spiral(5, 300, 9, 9), 0.05).slice_count, 0u);
  EXPECT_EQ(MeasureHeightSlices({}, {Vec3(1, 1, 1)}, 0.05).slice_count, 0u);
  EXPECT_THROW(MeasureHeightSlices({Globe(5)}, {}, 0), PreconditionError);
}

TEST(CloudQuality, ARingWithoutPointsIsWarnedOfAndLayersAreNot) {
  const auto measure = [](const PointList& points) {
    const PointCloud cloud{points, std::vector<std::uint32_t>(points.size(), 0)};
    return *MeasureCloud(cloud, {Globe(5)}, {.min_spacing_mm = 0.05});
  };
  const auto even = measure(Spiral(5, 20000, 9, 9));
  ASSERT_TRUE(even.surface->slices);
  EXPECT_TRUE(even.warnings.empty()) << even.warnings.front().text;
  const auto ring = measure(Spiral(5, 20000, 1.0, 1.1));
  ASSERT_EQ(ring.warnings.size(), 1u);
  EXPECT_NE(ring.warnings[0].text.find("band"), std::string::npos);
  EXPECT_NE(ring.warnings[0].text.find("method even"), std::string::npos);
  PointList layers = Spiral(5, 20000, 9, 9);
  for (Vec3& p : layers) {
    const double z = 0.1 * std::round(p.z() / 0.1);
    const double across = std::sqrt(std::max(0.0, 25 - z * z));
    const double turn = std::atan2(p.y(), p.x());
    p = Vec3(across * std::cos(turn), across * std::sin(turn), z);
  }
  const auto layered = measure(layers);
  ASSERT_TRUE(layered.surface->slices);
  EXPECT_EQ(layered.surface->slices->smallest_ratio, 0);
  for (const Warning& warning : layered.warnings) {
    EXPECT_EQ(warning.text.find("band"), std::string::npos) << warning.text;
  }
}

}  // namespace
}  // namespace intaglio::proof
