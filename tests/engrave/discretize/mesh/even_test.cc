#include "engrave/discretize/mesh/even.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>

#include "engrave/mesh/import/mesh_import.h"
#include "engrave/mesh/placement.h"
#include "tests/engrave/discretize/figurines.h"
#include "tests/engrave/discretize/shapes.h"
#include "tests/engrave/discretize/surface_checks.h"
#include "tests/engrave/mesh/mesh_file.h"

namespace intaglio::discretize {
namespace {

// nanoflann adds squares in another order, and own spacings are single precision.
constexpr double kRounding = 1e-7;

std::unique_ptr<PointSource> Even(const mesh::TriangleMesh& mesh,
                                  const EvenOptions& options) {
  auto source = MakeEven(mesh, options);
  EXPECT_TRUE(source.has_value());
  return *std::move(source);
}

Mat3 SomeTurn() {
  return (Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized())).toRotationMatrix();
}

struct Shape {
  const char* name;
  mesh::TriangleMesh mesh;
  double distance_mm;
};

// Faces along the lattices' axes and not, triangles far larger and far smaller than the
// distance, slivers, borders, and a spike.
std::vector<Shape> Shapes() {
  MeshBuilder spike;
  const Vec3 tip(0, 0, 12);
  for (int i = 0; i < 4; ++i) {
    const auto corner = [](int k) {
      return Vec3(std::cos(k * std::numbers::pi / 2), std::sin(k * std::numbers::pi / 2),
                  0);
    };
    spike.Add(corner(i), corner((i + 1) % 4), tip);
  }
  MeshBuilder slivers;
  for (int i = 0; i < 200; ++i) {
    const double y = 0.02 * i;
    slivers.AddQuad(Vec3(0, y, 0), Vec3(8, y, 0.1), Vec3(8, y + 0.02, 0.1),
                    Vec3(0, y + 0.02, 0));
  }
  return {{"cube", Cube(5), 0.2},
          {"turned cube", Turned(Cube(5), SomeTurn()), 0.2},
          {"coarse sphere", Icosphere(4, 1, Vec3(1, 2, 3)), 0.2},
          {"fine sphere", Icosphere(2, 6, Vec3(1, 2, 3)), 0.15},
          {"torus", Torus(Vec3(0, 0, 0), 4, 1, 120, 40), 0.2},
          {"fan", Cylinder(3, 4, 500), 0.2},
          {"dome", OpenDome(4, 60, 20), 0.2},
          {"spike", spike.Take(), 0.15},
          {"slivers", slivers.Take(), 0.15}};
}

TEST(Even, PointsAreApartEvenAndEverywhere) {
  for (const auto& [name, mesh, distance_mm] : Shapes()) {
    SCOPED_TRACE(name);
    const auto source = Even(mesh, {.distance_mm = distance_mm});
    const SpacedCloud kept = Thinned(*source);
    ASSERT_GT(kept.size(), 100u);
    const Evenness even = EvennessOf(kept.points_mm);
    EXPECT_GE(even.smallest, distance_mm * (1 - kRounding));
    EXPECT_LE(even.variation, 0.04);
    EXPECT_LE(LargestGap(mesh, kept.points_mm, distance_mm / 5), 1.15 * distance_mm);
  }
}

TEST(Even, PointsLieOnTheSurface) {
  for (const auto& [name, mesh, distance_mm] : Shapes()) {
    if (mesh.triangles.size() > 5000) continue;  // brute force
    SpacedCloud cloud = PointsOf(*Even(mesh, {.distance_mm = 2 * distance_mm}));
    for (std::size_t i = 0; i < cloud.size(); i += 1 + cloud.size() / 500) {
      ASSERT_LE(DistanceToMesh(cloud.points_mm[i], mesh), 1e-9) << name;
    }
  }
}

TEST(Even, CandidatesFollowTheAreaNotTheTriangles) {
  const EvenOptions options{.distance_mm = 0.5};
  const std::size_t coarse = PointsOf(*Even(Cube(5, 1), options)).size();
  const std::size_t fine = PointsOf(*Even(Cube(5, 100), options)).size();
  // The fine one's vertices are closer than the step: at most one more for each cube.
  EXPECT_LT(static_cast<double>(fine), 2.2 * static_cast<double>(coarse));
  EXPECT_GT(fine, coarse);
}

TEST(Even, SharedEdgesHaveNoDoubledPoints) {
  for (const auto& [name, mesh, distance_mm] : Shapes()) {
    auto points = Sorted(PointsOf(*Even(mesh, {.distance_mm = distance_mm})));
    EXPECT_EQ(std::adjacent_find(points.begin(), points.end()), points.end()) << name;
  }
}

TEST(Even, IsTheSameInEveryCutByHeight) {
  for (const auto& [name, mesh, distance_mm] : Shapes()) {
    SCOPED_TRACE(name);
    const Box3 box = mesh.Bounds();
    ExpectSameInRanges(*Even(mesh, {.distance_mm = distance_mm}),
                       {box.min_mm.z(), box.center_mm().z(), box.center_mm().z() + 0.01,
                        box.max_mm.z()});
  }
}

TEST(Even, TheSequenceOfTrianglesDoesNotMatter) {
  mesh::TriangleMesh mesh = Icosphere(3, 3, Vec3(0, 0, 0));
  const EvenOptions options{.distance_mm = 0.3};
  const auto points = Sorted(PointsOf(*Even(mesh, options)));
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(4));
  EXPECT_EQ(Sorted(PointsOf(*Even(mesh, options))), points);
}

TEST(Even, AnImageMakesItDenserAndSparser) {
  const auto square = Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 0.001));
  const auto right = [](const Vec3& p) { return p.x() > 5 ? 1.0 : 0.0; };
  const auto source = Even(
      square,
      {.distance_mm = 0.1, .sparse_distance_mm = 0.4, .density = DensityByPlace(right)});
  EXPECT_GE(source->MaxSpacing(), 0.4);
  const SpacedCloud kept = Thinned(*source);
  const auto dense = static_cast<double>(
      std::count_if(kept.points_mm.begin(), kept.points_mm.end(), right));
  // Sixteen times as many, but for the border between them.
  EXPECT_NEAR(dense / (static_cast<double>(kept.size()) - dense), 16, 3);
  ExpectSameInRanges(*source, {0.0005});
}

TEST(Even, GreyIsInProportion) {
  EXPECT_DOUBLE_EQ(SpacingFor(1, 0.1, 0.4), 0.1);
  EXPECT_DOUBLE_EQ(SpacingFor(0, 0.1, 0.4), 0.4);
  EXPECT_DOUBLE_EQ(SpacingFor(-3, 0.1, 0.4), 0.4);
  const double half = SpacingFor(0.5, 0.1, 0.4);
  EXPECT_NEAR(1 / (half * half), 0.5 * (100 + 6.25), 1e-9);
}

TEST(Even, LightAndBendingAreSeen) {
  const auto sphere = Icosphere(2, 5, Vec3(0, 0, 0));
  const Density light = DensityByLight(sphere, Vec3(0, 0, 3));
  const Density bending = DensityByCurvature(sphere, 1);
  for (std::uint32_t t = 0; t < sphere.triangles.size(); t += 37) {
    const Vec3 p = (sphere.vertices[sphere.triangles[t][0]] +
                    sphere.vertices[sphere.triangles[t][1]] +
                    sphere.vertices[sphere.triangles[t][2]]) /
                   3;
    // Lambert of a sphere; its normal turns by 1 / radius. The mesh's facets: 1 %.
    EXPECT_NEAR(light({p, t, 0}), std::max(0.0, p.normalized().z()), 0.02);
    EXPECT_NEAR(bending({p, t, 0}), 0.5, 0.01);
  }
  const auto cube = Cube(5, 10);
  const Density flat = DensityByCurvature(cube, 1);
  int inner = 0;
  for (std::uint32_t t = 0; t < cube.triangles.size(); ++t) {
    Box3 box;
    for (const std::uint32_t v : cube.triangles[t]) box.Extend(cube.vertices[v]);
    // Vertices beside an edge see its turned normals.
    if (((box.center_mm().array() - 2.5).abs() > 1.6).count() > 1) continue;
    EXPECT_NEAR(flat({box.center_mm(), t, 0}), 0, 1e-9);
    ++inner;
  }
  EXPECT_GT(inner, 100);
}

TEST(Even, ShellsAreAsDeepAsTheyShouldBe) {
  for (const auto& [name, mesh] :
       {std::pair("sphere", Icosphere(5, 4, Vec3(0, 0, 0))),
        std::pair("cube", Turned(Cube(6), SomeTurn())),
        std::pair("torus", Torus(Vec3(0, 0, 0), 5, 1.2, 60, 30))}) {
    SCOPED_TRACE(name);
    const auto source =
        Even(mesh, {.distance_mm = 0.4, .surface = false, .depths_mm = {0.5, 1}});
    const SpacedCloud kept = Thinned(*source);
    ASSERT_GT(kept.size(), 400u);
    for (std::size_t i = 0; i < kept.size(); i += 3) {
      const double depth_mm = DistanceToMesh(kept.points_mm[i], mesh);
      const double nearest = depth_mm < 0.75 ? 0.5 : 1;
      // 1.5 %: the faces of the meshes are flat and their shells' vertices are not.
      ASSERT_NEAR(depth_mm, nearest, 0.015 * nearest);
    }
    ExpectSameInRanges(*source, {0, 0.3});
  }
}

TEST(Even, ShellsDeeperThanTheModelAreLeftOutAndCounted) {
  const auto plate = Cuboid(Vec3(0, 0, 0), Vec3(10, 10, 1));
  const auto source =
      Even(plate, {.distance_mm = 0.5, .surface = false, .depths_mm = {0.8}});
  SpacedCloud cloud;
  const auto statistics = *source->AddPoints({}, 0, {}, cloud);
  EXPECT_EQ(cloud.size(), 0u);
  EXPECT_GT(statistics.shallow_count, 1000u);
}

TEST(Even, TooManyCandidatesAndCancellationAreErrors) {
  const auto large = Even(Cube(900), {.distance_mm = 0.01});
  SpacedCloud cloud;
  const auto many = large->AddPoints({}, 0, {}, cloud);
  ASSERT_FALSE(many.has_value());
  EXPECT_EQ(many.error().code, ErrorCode::kTooLarge);
  const auto small = Even(Cube(9), {.distance_mm = 1});
  const auto cancelled = small->AddPoints(
      {}, 0, [](auto, auto) { return false; }, cloud);
  ASSERT_FALSE(cancelled.has_value());
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
}

TEST(Even, NothingIsMadeOfNothing) {
  mesh::TriangleMesh point;
  point.vertices = {Vec3(1, 1, 1)};
  point.triangles = {{0, 0, 0}};
  SpacedCloud cloud;
  const auto statistics = *Even(point, {})->AddPoints({}, 0, {}, cloud);
  EXPECT_EQ(statistics.rejected_triangle_count, 1u);
  EXPECT_LE(cloud.size(), 1u);
  EXPECT_TRUE(Even({}, {})->Bounds().empty());
  EXPECT_EQ(PointsOf(*Even({}, {})).size(), 0u);
}

/// Meshes as they come, 20 mm large: triangles of every size beside the distance.
void ExpectEven(const std::string& name, const mesh::TriangleMesh& model) {
  SCOPED_TRACE(name);
  mesh::Placement placement;
  placement.fit = mesh::FitLargest{20};
  const auto mesh = *mesh::PlaceInBlock(model, placement, Vec3(30, 30, 30));
  const double distance_mm = 0.25;
  const SpacedCloud kept = Thinned(*Even(mesh, {.distance_mm = distance_mm}));
  const Evenness even = EvennessOf(kept.points_mm);
  const double gap_mm = LargestGap(mesh, kept.points_mm, distance_mm / 4);
  ::testing::Test::RecordProperty(name + "_variation", std::to_string(even.variation));
  ::testing::Test::RecordProperty(name + "_gap_ratio",
                                  std::to_string(gap_mm / distance_mm));
  EXPECT_GE(even.smallest, distance_mm * (1 - kRounding));
  EXPECT_LE(even.variation, 0.06);
  EXPECT_LE(gap_mm, 1.2 * distance_mm);
}

TEST(EvenOnFigurines, IsEven) {
  const std::vector<std::pair<const char*, mesh::TriangleMesh>> meshes = {
      {"figurine", Figurine(6)},
      {"scan with holes", WithHoles(Figurine(6), 5)},
      {"coarse figurine", Figurine(4)},
      {"knot", Trefoil(0.5, 300, 24)},
      {"pinched", PinchedTorus(5, 60, 49)},
      {"machined", PiercedPlate(7.3, 3)},
      {"assembly", InARow(WithHoles(Figurine(3), 2), 3)}};
  for (const auto& [name, mesh] : meshes) ExpectEven(name, mesh);
}

TEST(EvenOnMeasuredMeshes, IsEven) {
  const auto part =
      mesh::ImportMesh(INTAGLIO_SOURCE_DIR "/tests/data/trimesh/featuretype.STL");
  ASSERT_TRUE(part.has_value()) << part.error().message;
  ExpectEven("featuretype", *part);
}

TEST(EvenOnMeasuredMeshes, IsEvenOnThoseOfOthers) {
  const char* folder = std::getenv("INTAGLIO_MESHES");
  if (folder == nullptr) {
    GTEST_SKIP() << "INTAGLIO_MESHES names no folder with meshes such as bunny.obj; "
                    "tests/data/README.md says where they come from";
  }
  int read = 0;
  for (const char* file : {"bunny.obj", "cow.obj", "fandisk.stl", "horse.stl", "Duck.glb",
                           "counterXP.3MF"}) {
    if (!std::filesystem::exists(std::filesystem::path(folder) / file)) continue;
    const auto imported = mesh::ImportMesh(std::filesystem::path(folder) / file);
    ASSERT_TRUE(imported.has_value()) << imported.error().message;
    ExpectEven(file, *imported);
    ++read;
  }
  EXPECT_GT(read, 0) << folder << " has none of the known files";
}

}  // namespace
}  // namespace intaglio::discretize
