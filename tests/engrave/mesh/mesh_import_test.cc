#include "engrave/mesh/import/mesh_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/test_meshes.h"
#include "tests/test_folder.h"

// A box of 1 x 2 x 3 is written in every format by hand and must come back as the same
// set of triangles.

namespace intaglio::mesh {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const Vec3 kSize(1, 2, 3);

Result<TriangleMesh> Import(const std::string& bytes, std::string_view extension,
                            const ImportOptions& options = {}) {
  return ImportMeshFromMemory(std::as_bytes(std::span(bytes.data(), bytes.size())),
                              extension, options, "box");
}

/// The triangles as corner coordinates, each beginning with its smallest corner, sorted.
std::vector<std::array<double, 9>> Surface(const TriangleMesh& mesh) {
  std::vector<std::array<double, 9>> surface;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> corners;
    for (int c = 0; c < 3; ++c) {
      const Vec3& v = mesh.vertices[t[c]];
      corners[c] = {v.x(), v.y(), v.z()};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                corners.end());
    surface.emplace_back();
    for (int i = 0; i < 9; ++i) surface.back()[i] = corners[i / 3][i % 3];
  }
  std::sort(surface.begin(), surface.end());
  return surface;
}

TriangleMesh Moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v += by;
  return mesh;
}

void ExpectTheBox(const Result<TriangleMesh>& mesh, const TriangleMesh& expected) {
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  EXPECT_EQ(Surface(*mesh), Surface(expected));
  EXPECT_EQ(mesh->vertices.size(), 8u) << "not welded";
}

void ExpectError(const Result<TriangleMesh>& mesh, ErrorCode code, const char* part) {
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, code) << mesh.error().message;
  EXPECT_THAT(mesh.error().message, HasSubstr(part));
}

constexpr char kIdentity[] = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

TEST(MeshImport, ReadsTheBoxFromEveryFormat) {
  const TriangleMesh box = BoxMesh(kSize);
  ExpectTheBox(Import(AsciiStl(box), "stl"), box);
  ExpectTheBox(Import(BinaryStl(box), ".STL"), box);
  ExpectTheBox(Import(Obj(box), "obj"), box);
  ExpectTheBox(Import(Ply(box), "ply"), box);
  ExpectTheBox(Import(Dae(box, "", kIdentity), "dae"), box);
  ExpectTheBox(Import(ThreeDs(box), "3ds"), box);
  ExpectTheBox(Import(Gltf(box, "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"), "gltf"), box);
}

TEST(MeshImport, AppliesNodeTransforms) {
  const TriangleMesh box = BoxMesh(kSize);
  ExpectTheBox(Import(Dae(box, "", "1 0 0 10 0 1 0 20 0 0 1 30 0 0 0 1"), "dae"),
               Moved(box, {10, 20, 30}));
  ExpectTheBox(Import(Gltf(box, "1,0,0,0,0,1,0,0,0,0,1,0,10,20,30,1"), "gltf"),
               Moved(box, {10, 20, 30}));
}

TEST(MeshImport, MirroringTransformKeepsFacesOutward) {
  const auto mesh =
      Import(Gltf(BoxMesh(kSize), "-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"), "gltf");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  EXPECT_EQ(mesh->Bounds().min_mm, Vec3(-1, 0, 0));
  EXPECT_EQ(Diagnose(*mesh).signed_volume_mm3, 6);
}

TEST(MeshImport, DaeComesInMmByItsUnitWithTheFilesAxes) {
  const auto mesh =
      Import(Dae(BoxMesh(kSize),
                 R"(<unit meter="0.001" name="mm"/><up_axis>Z_UP</up_axis>)", kIdentity),
             "dae");
  ASSERT_TRUE(mesh.has_value());
  // 0.001 is a float in the library: 1 part in 10^7.
  EXPECT_LT((mesh->Bounds().size_mm() - kSize).norm(), 1e-6);
}

TEST(MeshImport, ThreeMfIsInMmByItsUnitAndPlacesEachItem) {
  const TriangleMesh box = BoxMesh(kSize);
  const auto mesh = Import(ThreeMf(box, "inch", "0 1 0 -1 0 0 0 0 1 10 20 30"), "3mf");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  TriangleMesh expected = box;
  // In 3MF a point is a row to the left of the matrix: (x, y, z) -> (-y, x, z) + move.
  for (const Vec3& v : box.vertices) {
    expected.vertices.emplace_back(10 - v.y(), 20 + v.x(), 30 + v.z());
  }
  for (const Triangle& t : box.triangles) {
    expected.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  }
  for (Vec3& v : expected.vertices) v *= 25.4;
  EXPECT_EQ(Surface(*mesh), Surface(expected));
  EXPECT_EQ(Diagnose(*mesh).component_count, 2u);
}

TEST(MeshImport, DamagedThreeMfIsAnErrorAndNoAbort) {
  const std::string whole =
      ThreeMf(BoxMesh(kSize), "millimeter", "1 0 0 0 1 0 0 0 1 10 20 30");
  ASSERT_TRUE(Import(whole, "3mf").has_value());
  std::string damaged = whole;  // the model no longer agrees with its checksum
  damaged[damaged.find("<vertex x=\"0\"") + 11] = '5';
  ExpectError(Import(damaged, "3mf"), ErrorCode::kUnreadable, "cannot be read as 3mf");
  for (std::size_t size = 1; size < whole.size(); size += 97) {
    EXPECT_FALSE(Import(whole.substr(0, size), "3mf").has_value()) << size;
  }
}

TEST(MeshImport, FileCutAnywhereIsAnErrorOrAWarning) {
  const TriangleMesh box = BoxMesh(kSize);
  const std::vector<std::pair<const char*, std::string>> files = {
      {"stl", AsciiStl(box)},
      {"stl", BinaryStl(box)},
      {"obj", Obj(box)},
      {"ply", Ply(box)},
      {"dae", Dae(box, "", kIdentity)},
      {"gltf", Gltf(box, "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1")},
      {"3ds", ThreeDs(box)}};
  for (const auto& [extension, whole] : files) {
    for (std::size_t size = 1; size < whole.size(); size += 3) {
      const auto mesh = Import(whole.substr(0, size), extension);
      if (!mesh) {
        EXPECT_FALSE(mesh.error().message.empty());
      } else if (Surface(*mesh) != Surface(box)) {
        // A text can be cut and still be a model, and the library makes up a PLY's
        // missing rows by repeating the last one: the diagnosis detects that.
        EXPECT_FALSE(WarningsOf(Diagnose(*mesh), "box").empty()) << extension << size;
      }
    }
  }
}

TEST(MeshImport, PlyThatClaimsMoreRowsThanItHasBytesIsAnError) {
  for (const char* element : {"element vertex ", "element face "}) {
    for (const char* count : {"2000000000", "99999999999999999999"}) {
      std::string ply = Ply(BoxMesh(kSize));
      const std::size_t at = ply.find(element) + std::strlen(element);
      ply.replace(at, ply.find('\n', at) - at, count);
      ExpectError(Import(ply, "ply"), ErrorCode::kUnreadable, "too few for \"element ");
    }
  }
}

// The library writes the rows of the second one behind its array.
TEST(MeshImport, PlyWithTwoListsOfAKindIsAnError) {
  const std::string box = Ply(BoxMesh(kSize));
  const std::size_t end = box.find("end_header");
  for (const char* more :
       {"element vertex 2\nproperty float x\n",
        "\t element  vertex 2\nproperty float x\n",
        "element face 1\nproperty list uchar int vertex_indices\n",
        "element tristrips 1\nproperty list int int vertex_indices\n"}) {
    std::string ply = box;
    ply.insert(end, more);
    ExpectError(Import(ply, "ply"), ErrorCode::kUnreadable, "its header declares");
  }
  std::string ply = box;
  ply.insert(end, "comment element vertex 2\n");
  ExpectTheBox(Import(ply, "ply"), BoxMesh(kSize));
}

TEST(MeshImport, PlyElementMayHaveDigitsInItsName) {
  std::string ply = Ply(BoxMesh(kSize));
  ply.replace(ply.find("element face"), 0, "element row2000000000 0\nproperty float a\n");
  ExpectTheBox(Import(ply, "ply"), BoxMesh(kSize));
}

TEST(MeshImport, ThreeMfThatUnpacksToTooMuchIsRefused) {
  std::string bomb = ThreeMf(BoxMesh(kSize), "millimeter", "1 0 0 0 1 0 0 0 1 10 20 30");
  ImportOptions options;
  options.max_file_bytes = bomb.size();  // it is stored, so its parts are smaller
  EXPECT_TRUE(Import(bomb, "3mf", options).has_value());
  // The first entry of the directory declares an unpacked size of 51 times the archive.
  const auto claimed = static_cast<std::uint32_t>(51 * bomb.size() + 1000);
  std::memcpy(bomb.data() + bomb.find("PK\1\2") + 24, &claimed, sizeof claimed);
  ExpectError(Import(bomb, "3mf"), ErrorCode::kTooLarge, "more than 50 times");
}

TEST(MeshImport, PlyHeaderThatDoesNotEndIsAnError) {
  std::string ply = Ply(BoxMesh(kSize));
  ply.replace(ply.find("end_header"), 10, "end_Header");
  ExpectError(Import(ply, "ply"), ErrorCode::kUnreadable,
              "line 9 is not a line of a PLY");
  ply.resize(ply.find("end_Header"));
  ExpectError(Import(ply, "ply"), ErrorCode::kUnreadable, "ends with end_header");
}

TEST(MeshImport, FileOfAnotherKindIsNotReadAsThatKind) {
  const TriangleMesh box = BoxMesh(kSize);
  const std::string ply = Ply(box);
  for (const char* extension : {"gltf", "glb", "3mf", "dae", "3ds", "stl", "obj"}) {
    EXPECT_FALSE(Import(ply, extension).has_value()) << extension;
    // A PLY cut within its header is read for ever.
    EXPECT_FALSE(Import(ply.substr(0, 60), extension).has_value()) << extension;
  }
}

TEST(MeshImport, DaeWithTextAmongItsIndicesIsAnError) {
  std::string dae = Dae(BoxMesh(kSize), "", kIdentity);
  dae.insert(dae.find("<p>") + 4, "i");
  ExpectError(Import(dae, "dae"), ErrorCode::kUnreadable, "something other than numbers");
}

// The library reads wherever an accessor points.
TEST(ImportMesh, ADaeWhoseAccessorsReachTooFarIsRefused) {
  const std::string dae = Dae(BoxMesh(kSize), "", kIdentity);
  const auto with = [&dae](const std::string& after, const std::string& what,
                           const std::string& instead) {
    std::string changed = dae;
    const std::size_t at = changed.find(what, changed.find(after));
    EXPECT_NE(at, std::string::npos) << what;
    return changed.replace(at, what.size(), instead);
  };
  EXPECT_TRUE(Import(dae, "dae"));
  // One without an inside, of one number, reads none of the next one's three.
  EXPECT_TRUE(Import(with("<source", "<source",
                          "<source id=\"q\"><float_array id=\"b\" count=\"1\">0"
                          "</float_array><technique_common><accessor source=\"#b\" "
                          "count=\"1\"/></technique_common></source><source"),
                     "dae"));
  const char* too_far = "exceeds the";
  ExpectError(Import(with("<float_array", "count=\"", "count=\"0\" of=\""), "dae"),
              ErrorCode::kUnreadable, too_far);
  ExpectError(Import(with("<float_array", "count=\"", "cuont=\""), "dae"),
              ErrorCode::kUnreadable, "has no count");
  ExpectError(Import(with("<accessor", "count=\"", "count=\"9"), "dae"),
              ErrorCode::kUnreadable, too_far);
  ExpectError(Import(with("<accessor", "stride=\"3", "stride=\"4"), "dae"),
              ErrorCode::kUnreadable, too_far);
  ExpectError(Import(with("<accessor", "count=\"", "offset='1' count=\""), "dae"),
              ErrorCode::kUnreadable, too_far);
  ExpectError(Import(with("<accessor", "count=\"", "count=\"x"), "dae"),
              ErrorCode::kUnreadable, "has no source");
}

TEST(MeshImport, CutsPolygonsIntoTriangles) {
  const auto mesh = Import(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 2 0\nf 1 2 3 4\nf 4 3 5\n", "obj");
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->triangles.size(), 3u);
  const MeshDiagnosis d = Diagnose(*mesh);
  EXPECT_EQ(d.vertex_count, 5u);
  EXPECT_NEAR(d.area_mm2, 1.5, 1e-12);  // of sums of a few doubles
  EXPECT_EQ(d.flipped_edge_count, 0u);
}

TEST(MeshImport, LeavesOutLinesAndUnusedVertices) {
  const auto mesh = Import("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\nl 1 4\n", "obj");
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->vertices.size(), 3u);
  EXPECT_EQ(mesh->triangles.size(), 1u);
}

TEST(MeshImport, KeepsTheFloatExactly) {
  const std::string bytes = BinaryStl([] {
    TriangleMesh mesh;
    mesh.vertices = {{0.1f, 1e-30f, 3e30f}, {1.0f / 3, 0, 0}, {0, 16777217.0f, -0.0f}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
  }());
  const auto mesh = Import(bytes, "stl");
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->vertices[0], Vec3(double{0.1f}, double{1e-30f}, double{3e30f}));
  EXPECT_FALSE(std::signbit(mesh->vertices[2].z())) << "-0.0 becomes 0.0";
}

TEST(MeshImport, ReportsWhatIsWrongWithBytes) {
  const std::string stl = BinaryStl(BoxMesh(kSize));
  ExpectError(Import("", "stl"), ErrorCode::kUnreadable, "box: the file is empty");
  ExpectError(Import(stl, "dxf"), ErrorCode::kUnsupported,
              "export it as one of stl, obj");
  ExpectError(Import(stl, ""), ErrorCode::kUnsupported, "");
  ExpectError(Import(stl.substr(0, stl.size() - 60), "stl"), ErrorCode::kUnreadable,
              "cannot be read as stl");
  ExpectError(Import("v 0 0 0\nv 1 0 0\nl 1 2\n", "obj"), ErrorCode::kMissing,
              "has no triangles");
  ExpectError(Import("solid nothing\nendsolid nothing\n", "stl"), ErrorCode::kMissing,
              "has no triangles");
}

TEST(MeshImport, RefusesCoordinatesThatAreNotFinite) {
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    TriangleMesh mesh = BoxMesh(kSize);
    mesh.vertices[5].y() = bad;
    ExpectError(Import(BinaryStl(mesh), "stl"), ErrorCode::kInvalidValue,
                "which is not finite");
  }
}

TEST(MeshImport, KeepsItsLimits) {
  const std::string stl = BinaryStl(BoxMesh(kSize));
  ImportOptions options;
  options.max_triangles = 12;
  options.max_file_bytes = stl.size();
  EXPECT_TRUE(Import(stl, "stl", options).has_value());
  options.max_triangles = 11;
  ExpectError(Import(stl, "stl", options), ErrorCode::kTooLarge, "11 triangles");
  options.max_triangles = 12;
  options.max_file_bytes = stl.size() - 1;
  ExpectError(Import(stl, "stl", options), ErrorCode::kTooLarge, "bytes");
}

TEST(MeshImport, AnEmptyFileIsAnError) {
  ExpectError(Import("", "obj"), ErrorCode::kUnreadable, "is empty");
}

TEST(MeshImport, GivesTheSameMeshTwice) {
  const std::string obj = Obj(BoxMesh(kSize));
  const auto first = Import(obj, "obj");
  const auto second = Import(obj, "obj");
  EXPECT_EQ(first->vertices, second->vertices);
  EXPECT_EQ(first->triangles, second->triangles);
}

/// Three objects: a triangle at height 0, one at 1 of two groups, one at 3.
constexpr char kThreeObjects[] =
    "o ground\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    "o first\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 4 5 6\n"
    "g roof\nv 0 0 3\nv 1 0 3\nv 0 1 3\nf 7 8 9\n";

std::vector<double> HeightsOf(const Result<TriangleMesh>& mesh) {
  EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().message);
  std::vector<double> heights;
  if (!mesh) return heights;
  for (const Triangle& t : mesh->triangles) heights.push_back(mesh->vertices[t[0]].z());
  return heights;
}

TEST(MeshImport, ObjectsAreChosenByTheirNames) {
  using ::testing::ElementsAre;
  EXPECT_THAT(HeightsOf(Import(kThreeObjects, "obj")), ElementsAre(0, 1, 3));
  EXPECT_THAT(HeightsOf(Import(kThreeObjects, "obj", {.objects = {"first"}})),
              ElementsAre(1));
  EXPECT_THAT(HeightsOf(Import(kThreeObjects, "obj", {.objects = {"roof", "ground"}})),
              ElementsAre(0, 3));
  ExpectError(Import(kThreeObjects, "obj", {.objects = {"ground", "cellar"}}),
              ErrorCode::kMissing,
              "objects: the file has no object \"cellar\" with faces; its objects are "
              "\"ground\", \"first\", \"roof\"");
  ExpectError(Import(BinaryStl(BoxMesh(kSize)), "stl", {.objects = {"box"}}),
              ErrorCode::kMissing, "it names none; remove the field objects");
}

TEST(MeshImport, NodesOfAGltfAreObjectsWithAllThatIsBelowThem) {
  const std::string one = Gltf(BoxMesh(kSize), "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1");
  const auto replaced = [](std::string text, const std::string& from,
                           const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  // A body, and a lid in a node of its own above it.
  std::string gltf =
      replaced(one, R"("scenes":[{"nodes":[0]}])", R"("scenes":[{"nodes":[0,1]}])");
  gltf = replaced(gltf, R"("nodes":[{"mesh":0,)", R"("nodes":[{"name":"body","mesh":0,)");
  gltf = replaced(gltf, "]}],\n\"meshes\"",
                  R"(]},{"name":"lid","translation":[0,0,10],"children":[2]},
{"name":"knob","mesh":0}],"meshes")");
  EXPECT_EQ(Import(gltf, "gltf")->triangles.size(), 24u);
  for (const char* name : {"lid", "knob"}) {
    const auto lid = Import(gltf, "gltf", {.objects = {name}});
    ASSERT_TRUE(lid) << lid.error().message;
    EXPECT_EQ(lid->triangles.size(), 12u);
    EXPECT_EQ(lid->Bounds().min_mm.z(), 10);
  }
  EXPECT_EQ(Import(gltf, "gltf", {.objects = {"body"}})->Bounds().min_mm.z(), 0);
  ExpectError(Import(gltf, "gltf", {.objects = {"cup"}}), ErrorCode::kMissing,
              "its objects are \"body\", \"lid\", \"knob\"");
}

}  // namespace
}  // namespace intaglio::mesh
