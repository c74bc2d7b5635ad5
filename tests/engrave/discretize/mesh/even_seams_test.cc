// Whether the seams of the slabs can be found in the points of the method even.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "engrave/discretize/cloud.h"
#include "engrave/discretize/mesh/even.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/mesh/placement.h"
#include "tests/engrave/discretize/figurines.h"
#include "tests/engrave/discretize/height_slices.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/surface_checks.h"
#include "tests/engrave/mesh/mesh_file.h"

namespace intaglio::discretize {
namespace {

constexpr double kMinRatio = 0.5;

CloudOptions CloudAt(double min_spacing_mm) {
  CloudOptions options;
  options.thinning.min_spacing_mm = min_spacing_mm;
  options.permitted_mm = {Vec3(-500, -500, -500), Vec3(500, 500, 500)};
  return options;
}

Sources EvenOn(const mesh::TriangleMesh& mesh, double distance_mm) {
  Sources sources;
  sources.push_back(*MakeEven(mesh, {.distance_mm = distance_mm}));
  return sources;
}

Discretized Made(const Sources& sources, double min_spacing_mm) {
  auto made = MakeCloud(sources, CloudAt(min_spacing_mm), {}, {}, {});
  EXPECT_TRUE(made.has_value());
  return *std::move(made);
}

mesh::TriangleMesh Cone(double radius_mm, double height_mm, int sides) {
  MeshBuilder cone;
  const auto rim = [&](int i) {
    const double turn = 2 * std::numbers::pi * (i % sides) / sides;
    return Vec3(radius_mm * std::cos(turn), radius_mm * std::sin(turn), 0);
  };
  for (int i = 0; i < sides; ++i) {
    cone.Add(rim(i), rim(i + 1), Vec3(0, 0, height_mm));
    cone.Add(rim(i + 1), rim(i), Vec3::Zero());
  }
  return cone.Take();
}

mesh::TriangleMesh Tilted(mesh::TriangleMesh mesh) {
  const Vec3 axis = Vec3(1, 2, 0.3).normalized();
  return Turned(std::move(mesh), Eigen::AngleAxisd(0.5, axis).toRotationMatrix());
}

/// No slice of half a distance has less than half of the points that its area lets
/// expect; nor has a slice of one distance along the rise, across which the seams lie.
void ExpectNoBands(const std::string& name, const mesh::TriangleMesh& mesh,
                   double distance_mm) {
  SCOPED_TRACE(name);
  const Sources sources = EvenOn(mesh, distance_mm);
  const HeightRange heights = sources[0]->Heights();
  ASSERT_GE(Slabs(heights, distance_mm).count(), 2u);
  const PointList points = Made(sources, distance_mm / 2).cloud.points_mm;
  const auto ratios = SliceRatios(mesh, points, distance_mm / 2);
  ASSERT_GT(ratios.size(), 40u);
  for (const SliceRatio& slice : ratios)
    EXPECT_GE(slice.ratio, kMinRatio) << slice.low_mm;
  const Vec3 rise = sources[0]->Rise(), level = Vec3::UnitZ().cross(rise).normalized();
  Mat3 turn;
  turn << level.transpose(), rise.cross(level).transpose(), rise.transpose();
  PointList turned;
  for (const Vec3& p : points) turned.push_back(turn * p);
  for (const SliceRatio& slice :
       SliceRatios(Turned(mesh, turn), turned, distance_mm, 80)) {
    EXPECT_GE(slice.ratio, kMinRatio) << "along the rise at " << slice.low_mm;
  }
  EXPECT_LE(LargestGap(mesh, points, distance_mm / 4), 1.2 * distance_mm);
  EXPECT_GE(EvennessOf(points).smallest, distance_mm * (1 - 1e-7));
}

TEST(EvenSeams, CannotBeFoundByTheNumberOfPointsAlongZ) {
  mesh::TriangleMesh ring = Torus(Vec3(0, 0, 0), 8, 3, 160, 80);
  for (Vec3& v : ring.vertices) v = Vec3(v.x(), -v.z(), v.y());
  const std::vector<std::pair<const char*, mesh::TriangleMesh>> meshes = {
      {"sphere", Icosphere(8, 5, Vec3::Zero())},
      {"torus", ring},
      {"tilted box", Tilted(Cube(10))},
      {"tilted plate", Tilted(Cuboid(Vec3(0, 0, 0), Vec3(12, 9, 4)))},
      {"cone", Cone(6, 16, 300)},
      {"figurine", Figurine(6)},
      {"scan with holes", WithHoles(Figurine(6), 5)}};
  for (const auto& [name, mesh] : meshes) ExpectNoBands(name, mesh, 0.15);
}

TEST(EvenSeams, CannotBeFoundOnThoseOfOthers) {
  const char* folder = std::getenv("INTAGLIO_MESHES");
  if (folder == nullptr) {
    GTEST_SKIP() << "INTAGLIO_MESHES names no folder with meshes such as bunny.obj; "
                    "tests/data/README.md says where they come from";
  }
  for (const char* file :
       {"bunny.obj", "cow.obj", "fandisk.stl", "horse.stl", "Duck.glb"}) {
    const auto imported = mesh::ImportMesh(std::filesystem::path(folder) / file);
    if (!imported) continue;
    mesh::Placement placement;
    placement.fit = mesh::FitLargest{30};
    const auto mesh = *mesh::PlaceInBlock(*imported, placement, Vec3(40, 40, 40));
    ExpectNoBands(file, mesh, 0.2);
  }
}

TEST(EvenSeams, WhoeverMakesThemTheyAreTheSame) {
  const auto mesh = Figurine(5);
  const Sources sources = EvenOn(mesh, 0.2);
  const Discretized whole = Made(sources, 0.1);
  const auto together = [&](std::size_t parts) {
    PointList points;
    std::uint64_t thinned = 0, candidates = 0;
    for (std::size_t i = 0; i < parts; ++i) {
      const auto part = MakeCloud(sources, CloudAt(0.1), {i, parts}, {}, {});
      points.insert(points.end(), part->cloud.points_mm.begin(),
                    part->cloud.points_mm.end());
      thinned += part->thinned_count;
      candidates += part->candidate_count;
    }
    EXPECT_EQ(thinned, whole.thinned_count);
    EXPECT_EQ(candidates, whole.candidate_count);
    EXPECT_EQ(candidates, thinned + points.size());
    return points;
  };
  EXPECT_EQ(together(2), whole.cloud.points_mm);
  EXPECT_EQ(together(7), whole.cloud.points_mm);
  const auto backwards = [](std::size_t count, const auto& work) {
    std::vector<std::jthread> threads;
    for (std::size_t i = count; i-- > 0;) threads.emplace_back(work, i);
  };
  EXPECT_EQ(MakeCloud(sources, CloudAt(0.1), {}, backwards, {})->cloud.points_mm,
            whole.cloud.points_mm);
}

// A job may have models of both rises, and a density that varies.
TEST(EvenSeams, KeepTheSpacingBesideOtherMethodsAndDensities) {
  const auto mesh = Figurine(5);
  const auto high = [](const Vec3& p) { return p.x() > 0 ? 1.0 : 0.0; };
  Sources sources;
  sources.push_back(*MakeEven(
      mesh,
      {.distance_mm = 0.15, .sparse_distance_mm = 0.4, .density = DensityByPlace(high)}));
  SectionOptions sections;
  sections.layer_distance_mm = sections.vertex_distance_mm = 0.2;
  sources.push_back(*MakeSections(Icosphere(6, 4, Vec3(2, 0, 0)), sections));
  ASSERT_NE(sources[0]->Rise(), sources[1]->Rise());
  const Discretized made = Made(sources, 0.1);
  EXPECT_GE(EvennessOf(made.cloud.points_mm).smallest, 0.1 * (1 - 1e-9));
  EXPECT_EQ(made.candidate_count, made.cloud.size() + made.thinned_count);
  PointList of_even, dense;
  for (std::size_t i = 0; i < made.cloud.size(); ++i) {
    if (made.cloud.source[i] == 0) of_even.push_back(made.cloud.points_mm[i]);
  }
  EXPECT_GT(of_even.size(), 5000u);
  EXPECT_LT(of_even.size() + 1000, made.cloud.size());
  EXPECT_GE(EvennessOf(of_even).smallest, 0.15 * (1 - 1e-7));
  const auto parts = [&](std::size_t i) {
    return MakeCloud(sources, CloudAt(0.1), {i, 2}, {}, {})->cloud.size();
  };
  EXPECT_EQ(parts(0) + parts(1), made.cloud.size());
}

}  // namespace
}  // namespace intaglio::discretize
