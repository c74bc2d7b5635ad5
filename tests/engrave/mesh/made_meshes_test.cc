#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>

#include "engrave/mesh/import/mesh_import.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/discretize/figurines.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/mesh_file.h"
#include "tests/test_folder.h"

// Meshes like those that people bring, computed and written as the programs write them
// that people use. Their topology follows from how they are made.

namespace intaglio::mesh {
namespace {

namespace fs = std::filesystem;
using namespace discretize;

constexpr char kCentimetres[] = "10,0,0,0,0,10,0,0,0,0,10,0,0,0,0,1";

/// The place of a component, turned about z by a multiple of 72 degrees: five screws
/// around a plate. In 3MF a point is a row to the left of the matrix.
std::string ScrewPlace(int i) {
  const double turn = 2 * std::numbers::pi * i / 5, c = std::cos(turn),
               s = std::sin(turn);
  return fmt::format("{} {} 0 {} {} 0 0 0 1 {} {} 8", c, s, -s, c, 40 * c, 40 * s);
}

/// A plate, and five times a screw that is a component of a component.
std::string PlateWithScrews() {
  std::string components = R"(<component objectid="1"/>)";
  for (int i = 0; i < 5; ++i) {
    components +=
        fmt::format(R"(<component objectid="10" transform="{}"/>)", ScrewPlace(i));
  }
  return ThreeMfOf("millimeter",
                   ThreeMfObject(1, PiercedPlate(8, 3)) + ThreeMfObject(2, Figurine(3)) +
                       R"(<object id="10"><components><component objectid="2"/>)"
                       R"(</components></object><object id="20"><components>)" +
                       components + "</components></object>",
                   R"(<item objectid="20" transform="1 0 0 0 1 0 0 0 1 -100 20 3"/>)",
                   true);
}

/// The expected properties of a file's mesh.
struct MadeFile {
  const char* file;
  std::function<std::string()> bytes;
  std::uint64_t triangle_count;
  std::uint64_t component_count;
  bool closed;
  /// 2 (1 - genus) a closed part, one less for each hole and each pinched vertex.
  std::int64_t euler_characteristic;
};

void PrintTo(const MadeFile& made, std::ostream* out) { *out << made.file; }

class MadeMeshes : public testing::TestWithParam<MadeFile> {};

TEST_P(MadeMeshes, AreWhatTheyWereMadeAs) {
  const fs::path file = test::FreshFolder() / GetParam().file;
  std::ofstream(file, std::ios::binary) << GetParam().bytes();
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_EQ(d.triangle_count, GetParam().triangle_count);
  EXPECT_EQ(d.component_count, GetParam().component_count);
  EXPECT_EQ(d.closed(), GetParam().closed);
  EXPECT_EQ(d.euler_characteristic, GetParam().euler_characteristic);
  EXPECT_EQ(d.vertex_count, mesh->vertices.size()) << "a vertex nobody uses";
  EXPECT_EQ(d.degenerate_triangle_count, 0u);
  EXPECT_EQ(d.flipped_triangle_count, 0u);
  EXPECT_GT(d.signed_volume_mm3, 0);
  EXPECT_EQ(WarningsOf(d, "m").empty(), d.closed());
}

INSTANTIATE_TEST_SUITE_P(
    Files, MadeMeshes,
    testing::Values(
        // Each hole takes the five triangles around a corner of the icosahedron.
        MadeFile{"scan.obj", [] { return Obj(WithHoles(Figurine(6), 5)); }, 81920 - 25, 1,
                 false, 2 - 5},
        MadeFile{"figurine.stl", [] { return BinaryStl(Figurine(6)); }, 81920, 1, true,
                 2},
        MadeFile{"pinched.obj", [] { return Obj(PinchedTorus(5, 60, 49)); }, 60 * 2 * 48,
                 1, true, 1},
        // By squares: 18 above, 18 below, 20 around and 12 in the holes.
        MadeFile{"machined.stl", [] { return AsciiStl(PiercedPlate(7.3, 3)); },
                 2 * (2 * 18 + 20 + 12), 1, true, 2 - 2 * 3},
        MadeFile{"knot.glb", [] { return Glb(Trefoil(0.5, 300, 24), kCentimetres); },
                 2 * 300 * 24, 1, true, 0},
        MadeFile{"screws.3mf", PlateWithScrews, 2 * (2 * 18 + 20 + 12) + 5 * 1280, 6,
                 true, 2 - 2 * 3 + 5 * 2},
        MadeFile{"assembly.ply",
                 [] { return BinaryPly(InARow(WithHoles(Figurine(2), 2), 112)); },
                 112 * (320 - 10), 112, false, 0}),
    [](const auto& made) {
      std::string name = made.param.file;
      for (char& c : name) {
        if (c == '.') c = '_';
      }
      return name;
    });

TEST(MadeMesh, ComponentsOfAThreeMfAreWhereTheFileStates) {
  const fs::path file = test::FreshFolder() / "screws.3mf";
  std::ofstream(file, std::ios::binary) << PlateWithScrews();
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  Box3 expected;
  const auto take = [&](const Vec3& p) { expected.Extend(p + Vec3(-100, 20, 3)); };
  const TriangleMesh plate = PiercedPlate(8, 3), screw = Figurine(3);
  for (const Vec3& v : plate.vertices) take(v);
  for (int i = 0; i < 5; ++i) {
    const double turn = 2 * std::numbers::pi * i / 5;
    const Mat3 turned = Eigen::AngleAxisd(turn, Vec3::UnitZ()).toRotationMatrix();
    for (const Vec3& v : screw.vertices)
      take(turned * (v + Vec3(40, 0, 0)) + Vec3(0, 0, 8));
  }
  const MeshDiagnosis d = Diagnose(*mesh);
  // The library keeps floats of up to 150 mm, so 8e-6 mm each, twice.
  EXPECT_LT((d.bounds_mm.min_mm - expected.min_mm).norm(), 5e-5);
  EXPECT_LT((d.bounds_mm.max_mm - expected.max_mm).norm(), 5e-5);
  const double volume_mm3 =
      Diagnose(plate).signed_volume_mm3 + 5 * Diagnose(screw).signed_volume_mm3;
  EXPECT_NEAR(d.signed_volume_mm3, volume_mm3, 1e-4 * volume_mm3);
}

// Programs write a normal of zeros where they have none; normals are not used. The volume
// of a tube is its section by the length of its axis (Pappus; a section of m corners).
TEST(MadeMesh, StlWithoutNormalsIsASoundSurface) {
  const fs::path file = test::FreshFolder() / "no_normals.stl";
  std::ofstream(file, std::ios::binary) << BinaryStl(Trefoil(0.4, 900, 24));
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_TRUE(d.closed());
  EXPECT_EQ(d.euler_characteristic, 0);
  double length_mm = 0;
  const int steps = 100'000;
  for (int i = 0; i < steps; ++i) {
    const double t = 2 * std::numbers::pi * i / steps;
    length_mm += Vec3(std::cos(t) + 4 * std::cos(2 * t),
                      4 * std::sin(2 * t) - std::sin(t), -3 * std::cos(3 * t))
                     .norm() *
                 2 * std::numbers::pi / steps;
  }
  const double section_mm2 = 12 * 0.4 * 0.4 * std::sin(2 * std::numbers::pi / 24);
  // Chords of 900 steps, and rings that are not turned evenly: some 1e-4.
  EXPECT_NEAR(d.signed_volume_mm3, section_mm2 * length_mm,
              1e-3 * section_mm2 * length_mm);
}

}  // namespace
}  // namespace intaglio::mesh
