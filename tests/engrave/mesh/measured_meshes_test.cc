#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "engrave/mesh/mesh_diagnosis.h"
#include "engrave/mesh/mesh_import.h"

// Meshes as people have them: scans, CAD exports, and files that are broken.

namespace intaglio::mesh {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

fs::path Folder(const char* name) {
  return fs::path(INTAGLIO_SOURCE_DIR) / "../shared/data" / name;
}

/// What a file must turn out to be.
struct Expected {
  const char* file;
  /// Counted in the file: faces of the text formats, (size - 84) / 50 of a binary STL.
  std::uint64_t triangle_count;
  std::uint64_t component_count;
  bool closed;
  /// Of a closed surface, 2 (1 - genus) a part, one less for each pinched vertex.
  std::int64_t euler_characteristic;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.file; }

class MeasuredMeshes : public testing::TestWithParam<Expected> {};

TEST_P(MeasuredMeshes, IsWhatItIsKnownToBe) {
  const fs::path file = Folder("meshes") / GetParam().file;
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_EQ(d.triangle_count, GetParam().triangle_count);
  EXPECT_EQ(d.component_count, GetParam().component_count);
  EXPECT_EQ(d.closed(), GetParam().closed);
  EXPECT_EQ(d.euler_characteristic, GetParam().euler_characteristic);
  EXPECT_EQ(d.vertex_count, mesh->vertices.size()) << "a vertex nobody uses";
  EXPECT_EQ(d.flipped_triangle_count, 0u);
  EXPECT_EQ(Warnings(d, "m").empty(), d.closed() && d.signed_volume_mm3 > 0);
}

INSTANTIATE_TEST_SUITE_P(
    Files, MeasuredMeshes,
    testing::Values(Expected{"bunny.obj", 69451, 1, false, -3},
                    Expected{"horse.stl", 96966, 1, true, 2},
                    Expected{"cow.obj", 5804, 1, true, 1},
                    Expected{"fandisk.stl", 12946, 1, true, 2},
                    Expected{"Duck.glb", 4212, 1, true, 2},
                    Expected{"counterXP.3MF", 83750, 6, true, -38},
                    Expected{"cycloidal.ply", 43368, 112, false, -58},
                    Expected{"featuretype.STL", 3476, 1, false, -16}),
    [](const auto& file) {
      std::string name = file.param.file;
      for (char& c : name) {
        if (c == '.') c = '_';
      }
      return name;
    });

TEST(MeasuredMesh, ComponentsOfAThreeMfAreWhereTheFileSays) {
  const fs::path file = Folder("meshes") / "counterXP.3MF";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value());
  const MeshDiagnosis d = Diagnose(*mesh);
  // From the file's XML by a script that multiplies its matrices in doubles; the library
  // keeps floats of up to 310 mm, so 2e-5 mm each, twice.
  EXPECT_LT((d.bounds_mm.min_mm - Vec3(-111.48989, 5.779197, 255.860162)).norm(), 1e-4);
  EXPECT_LT((d.bounds_mm.max_mm - Vec3(193.31011, 310.187997, 281.698413)).norm(), 1e-4);
  // That error over the whole surface of 170 000 mm^2 would be 7; it averages out.
  EXPECT_NEAR(d.signed_volume_mm3, 888808.129, 1);
}

/// The error, or the warnings, that a broken file gives.
std::string Complaint(const char* name) {
  const auto mesh = ImportMesh(Folder("broken") / name);
  if (!mesh) return mesh.error().message;
  const auto warnings = Warnings(Diagnose(*mesh), name);
  return fmt::format("{}", fmt::join(warnings, "\n"));
}

TEST(BrokenMeshes, EachGivesAClearComplaint) {
  if (!fs::exists(Folder("broken"))) GTEST_SKIP() << "no " << Folder("broken");
  EXPECT_THAT(Complaint("empty.stl"), HasSubstr("empty.stl: it holds no triangles"));
  EXPECT_THAT(Complaint("stl_empty_bin.stl"), HasSubstr("stl_empty_bin.stl: it"));
  EXPECT_THAT(Complaint("obj_points.obj"), HasSubstr("not as points or lines"));
  EXPECT_THAT(Complaint("ply_empty_header.ply"), HasSubstr("cannot be read as ply"));
  EXPECT_THAT(Complaint("headless.ctm"), HasSubstr("export it as one of"));
  EXPECT_THAT(Complaint("broken_loop.dxf"), HasSubstr("export it as one of"));
  EXPECT_THAT(Complaint("broken_pair.dxf"), HasSubstr("export it as one of"));
}

TEST(BrokenMeshes, StlWithoutNormalsIsASoundSurface) {
  const fs::path file = Folder("broken") / "busted.STL";
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file;
  // What is broken are the normals, all of them zero; they are not used. The surface
  // itself is closed and a brute-force test of all pairs finds no triangle through
  // another.
  const auto mesh = ImportMesh(file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_EQ(d.triangle_count, 3878u);
  EXPECT_TRUE(d.closed());
  EXPECT_EQ(d.euler_characteristic, 2);
  EXPECT_GT(d.signed_volume_mm3, 0);
}

}  // namespace
}  // namespace intaglio::mesh
