#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "engrave/mesh/import/mesh_import.h"
#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/mesh/mesh_file.h"

// Meshes from practice: scans, CAD exports, and broken files. Those that may be
// redistributed are in tests/data; the others are read from the folder INTAGLIO_MESHES.

namespace intaglio::mesh {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const fs::path kData = fs::path(INTAGLIO_SOURCE_DIR) / "tests/data";

/// The expected properties of a file's mesh.
struct Expected {
  const char* file;
  /// Counted in the file: faces of the text formats, (size - 84) / 50 of a binary STL.
  std::uint64_t triangle_count;
  std::uint64_t component_count;
  bool closed;
  /// A closed surface has 2 (1 - genus) a part, one less for each pinched vertex.
  std::int64_t euler_characteristic;
};

void ExpectToBe(const fs::path& folder, const Expected& expected) {
  SCOPED_TRACE(expected.file);
  const auto mesh = ImportMesh(folder / expected.file);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_EQ(d.triangle_count, expected.triangle_count);
  EXPECT_EQ(d.component_count, expected.component_count);
  EXPECT_EQ(d.closed(), expected.closed);
  EXPECT_EQ(d.euler_characteristic, expected.euler_characteristic);
  EXPECT_EQ(d.vertex_count, mesh->vertices.size()) << "a vertex nobody uses";
  EXPECT_EQ(d.flipped_triangle_count, 0u);
  EXPECT_EQ(WarningsOf(d, "m").empty(), d.closed() && d.signed_volume_mm3 > 0);
}

TEST(MeasuredMeshes, AMachinedPartIsWhatItIsKnownToBe) {
  ExpectToBe(kData / "trimesh", {"featuretype.STL", 3476, 1, false, -16});
}

TEST(MeasuredMeshes, ThoseOfOthersAreWhatTheyAreKnownToBe) {
  const char* folder = std::getenv("INTAGLIO_MESHES");
  if (folder == nullptr) {
    GTEST_SKIP() << "INTAGLIO_MESHES names no folder with bunny.obj and others; "
                    "tests/data/README.md says where they come from";
  }
  int read = 0;
  for (const Expected& expected : {Expected{"bunny.obj", 69451, 1, false, -3},
                                   {"horse.stl", 96966, 1, true, 2},
                                   {"cow.obj", 5804, 1, true, 1},
                                   {"fandisk.stl", 12946, 1, true, 2},
                                   {"Duck.glb", 4212, 1, true, 2},
                                   {"counterXP.3MF", 83750, 6, true, -38},
                                   {"cycloidal.ply", 43368, 112, false, -58}}) {
    if (!fs::exists(fs::path(folder) / expected.file)) continue;
    ExpectToBe(folder, expected);
    ++read;
  }
  EXPECT_GT(read, 0) << folder << " has none of the known files";
}

/// The error, or the warnings, that a broken file gives.
std::string Complaint(const char* name) {
  const auto mesh = ImportMesh(kData / "broken" / name);
  if (!mesh) return mesh.error().message;
  const auto warnings = WarningsOf(Diagnose(*mesh), name);
  std::string texts;
  for (const Warning& warning : warnings) texts += warning.text + "\n";
  return texts;
}

TEST(BrokenMeshes, EachGivesAClearComplaint) {
  EXPECT_THAT(Complaint("empty.stl"), HasSubstr("empty.stl: it has no triangles"));
  EXPECT_THAT(Complaint("empty_binary.stl"), HasSubstr("empty_binary.stl: it"));
  EXPECT_THAT(Complaint("cut_short.stl"), HasSubstr("cut_short.stl: "));
  EXPECT_THAT(Complaint("points_only.obj"), HasSubstr("not as points or lines"));
  EXPECT_THAT(Complaint("no_such_vertex.obj"), HasSubstr("no_such_vertex.obj: "));
  EXPECT_THAT(Complaint("no_elements.ply"), HasSubstr("cannot be read as ply"));
  EXPECT_THAT(Complaint("unknown_kind.ctm"), HasSubstr("export it as one of"));
  EXPECT_THAT(Complaint("open_loop.dxf"), HasSubstr("export it as one of"));
  EXPECT_THAT(Complaint("loose_pair.dxf"), HasSubstr("export it as one of"));
}

}  // namespace
}  // namespace intaglio::mesh
