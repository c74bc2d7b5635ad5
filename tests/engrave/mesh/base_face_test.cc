#include "engrave/mesh/base_face.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/mesh/placement.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

/// A body of revolution about z, closed by fans: radius_mm at each height_mm.
TriangleMesh Turned(const std::vector<std::pair<double, double>>& radius_and_height_mm) {
  constexpr std::uint32_t kSides = 48;
  TriangleMesh mesh;
  for (const auto& [radius_mm, height_mm] : radius_and_height_mm) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double turn = 2 * std::numbers::pi * i / kSides;
      mesh.vertices.emplace_back(radius_mm * std::cos(turn), radius_mm * std::sin(turn),
                                 height_mm);
    }
  }
  const auto rings = static_cast<std::uint32_t>(radius_and_height_mm.size());
  for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const std::uint32_t a = ring * kSides + i, b = ring * kSides + (i + 1) % kSides;
      mesh.triangles.push_back({a, b, a + kSides});
      mesh.triangles.push_back({b, b + kSides, a + kSides});
    }
  }
  for (std::uint32_t i = 1; i + 1 < kSides; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    const std::uint32_t top = (rings - 1) * kSides;
    mesh.triangles.push_back({top, top + i, top + i + 1});
  }
  return mesh;
}

/// A bust: a wide base, a neck, a round head.
TriangleMesh Bust() {
  return Turned(
      {{12, 0}, {12, 4}, {5, 6}, {5, 14}, {9, 20}, {8, 26}, {3, 30}, {0.1, 31}});
}

TriangleMesh With(TriangleMesh mesh, UpAxis file_up) {
  Placement placement;
  placement.up = file_up;
  return *PlaceInBlock(mesh, placement, {60, 60, 60});
}

TEST(BaseFace, AModelOnItsBaseIsNotReported) {
  EXPECT_EQ(UpOfBaseFace(Bust()), std::nullopt);
}

TEST(BaseFace, ABaseAtTheTopIsUpsideDown) {
  EXPECT_EQ(UpOfBaseFace(With(Bust(), UpAxis::kMinusZ)), UpAxis::kMinusZ);
}

// A file with y up that is taken for z up: its base is at the lowest y.
TEST(BaseFace, ABaseInFrontLiesOnItsBack) {
  TriangleMesh y_up = Bust();
  const Mat3 turn = UprightFrom(UpAxis::kY).transpose();
  for (Vec3& v : y_up.vertices) v = turn * v;
  const auto up = UpOfBaseFace(y_up);
  ASSERT_EQ(up, UpAxis::kY);
  // What is advised puts it on its base.
  EXPECT_EQ(UpOfBaseFace(With(y_up, *up)), std::nullopt);
}

// As scanned: its base is hollow by a few tenths of a millimetre, nowhere plane.
TEST(BaseFace, TheRoughBaseOfAScannedFigureInFrontLiesOnItsBack) {
  const TriangleMesh scanned = Turned({{0.1, 0.4},
                                       {7, 0.3},
                                       {12, 0},
                                       {12.2, 4},
                                       {5, 6},
                                       {5, 14},
                                       {9, 20},
                                       {8, 26},
                                       {3, 30},
                                       {0.1, 31}});
  EXPECT_EQ(UpOfBaseFace(scanned), std::nullopt);
  TriangleMesh y_up = scanned;
  const Mat3 turn = UprightFrom(UpAxis::kY).transpose();
  for (Vec3& v : y_up.vertices) v = turn * v;
  EXPECT_EQ(UpOfBaseFace(y_up), UpAxis::kY);
  EXPECT_EQ(UpOfBaseFace(With(y_up, UpAxis::kY)), std::nullopt);
  EXPECT_EQ(UpOfBaseFace(With(scanned, UpAxis::kMinusZ)), UpAxis::kMinusZ);
}

TEST(BaseFace, ABallHasNoBase) {
  std::vector<std::pair<double, double>> circle;
  for (int i = 1; i < 60; ++i) {
    const double angle = std::numbers::pi * i / 60;
    circle.emplace_back(20 * std::sin(angle), -20 * std::cos(angle));
  }
  for (const UpAxis up : {UpAxis::kZ, UpAxis::kY, UpAxis::kMinusZ}) {
    EXPECT_EQ(UpOfBaseFace(With(Turned(circle), up)), std::nullopt);
  }
}

TEST(BaseFace, BoxesPlatesAndRoundThingsAreNotReported) {
  EXPECT_EQ(UpOfBaseFace(BoxMesh({10, 20, 30})), std::nullopt);
  EXPECT_EQ(UpOfBaseFace(BoxMesh({30, 1, 30})), std::nullopt) << "a standing plate";
  EXPECT_EQ(UpOfBaseFace(BoxMesh({30, 0, 30})), std::nullopt) << "a flat sheet";
  EXPECT_EQ(UpOfBaseFace(Turned({{0.1, 0}, {7, 3}, {10, 10}, {7, 17}, {0.1, 20}})),
            std::nullopt);
  EXPECT_EQ(UpOfBaseFace({}), std::nullopt);
}

// A goblet: its rim is flat and narrow, its foot is a disc.
TEST(BaseFace, AFootAndARimAreNoMistake) {
  EXPECT_EQ(UpOfBaseFace(Turned({{8, 0}, {8, 1}, {1, 2}, {1, 15}, {9, 22}, {10, 30}})),
            std::nullopt);
}

}  // namespace
}  // namespace intaglio::mesh
