// Models of the kinds that people reported with other programs. The files are our own;
// their areas are computed by arithmetic from the numbers written and the standards of
// their formats: tests/data/README.md.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "engrave/io/whole_file.h"
#include "engrave/mesh/files/polygon.h"
#include "tests/engrave/mesh/mesh_file.h"
#include "tests/test_folder.h"

namespace intaglio::mesh {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kFolder = INTAGLIO_SOURCE_DIR "/tests/data/kinds/";

double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    area += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() / 2;
  }
  return area;
}

struct FileArea {
  const char* file;
  double area_mm2;
};

class MeshesOfOthers : public ::testing::TestWithParam<FileArea> {};

TEST_P(MeshesOfOthers, HaveTheAreaOfTheirStandard) {
  const auto mesh = ImportMesh(kFolder + GetParam().file);
  ASSERT_TRUE(mesh) << mesh.error().message;
  // 32-bit floats have 1 part in 10^7 each.
  EXPECT_NEAR(AreaOf(*mesh), GetParam().area_mm2, 1e-5 * GetParam().area_mm2);
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, MeshesOfOthers,
    ::testing::Values(FileArea{"unit.3mf", 5200}, FileArea{"parts.3mf", 1050},
                      FileArea{"item_path.3mf", 450}, FileArea{"zip64.3mf", 5200},
                      FileArea{"unit.dae", 22 * 25.4 * 25.4}, FileArea{"notch.obj", 90},
                      FileArea{"dot.obj", 600}, FileArea{"far.obj", 1252.1562527746587},
                      FileArea{"cr.stl", 600},
                      FileArea{"line_feed.ply", 599.0050141186343}));

TEST(MeshesOfOthers, WhatCannotBeReadRightIsRefusedByName) {
  const std::pair<const char*, const char*> refused[] = {
      {"instances.glb", "EXT_mesh_gpu_instancing"},
      {"quantized.glb", "KHR_mesh_quantization"},
      {"two_files/scene.gltf", "scene.bin"}};
  for (const auto& [file, name] : refused) {
    const auto mesh = ImportMesh(kFolder + file);
    ASSERT_FALSE(mesh) << file;
    EXPECT_THAT(mesh.error().message, HasSubstr(name));
    EXPECT_THAT(mesh.error().message, HasSubstr(file));
  }
}

/// A GLB whose JSON lost its padding, `blanks` of it left in front of the other chunk.
std::string OddGlb(std::string glb, std::size_t cut, std::size_t blanks) {
  std::uint32_t size = 0;
  std::memcpy(&size, glb.data() + 12, 4);
  std::string json = glb.substr(20, size);
  json.erase(json.find_last_not_of(' ') + 1);
  json.append((4 - json.size() % 4) % 4 + 4 - cut, ' ');  // so that its size is odd
  const std::string rest = glb.substr(20 + size);
  size = static_cast<std::uint32_t>(json.size());
  std::memcpy(glb.data() + 12, &size, 4);
  glb = glb.substr(0, 20) + json + std::string(blanks, ' ') + rest;
  size = static_cast<std::uint32_t>(glb.size());
  std::memcpy(glb.data() + 8, &size, 4);
  return glb;
}

// As old exporters wrote them, the points right behind the text or at the next multiple
// of 4. The oracle: the same file as it is.
TEST(MeshesOfOthers, AGlbWhoseChunkIsNotAlignedIsReadWhereItsPointsBegin) {
  const auto bytes = io::ReadWholeFile(kFolder + "skin.glb", 1 << 20);
  ASSERT_TRUE(bytes);
  const auto whole = ImportMesh(kFolder + "skin.glb");
  ASSERT_TRUE(whole) << whole.error().message;
  for (const std::size_t cut : {1U, 2U, 3U}) {
    for (const std::size_t blanks : {std::size_t{0}, cut}) {
      const auto file = test::FreshFolder() / "odd.glb";
      std::ofstream(file, std::ios::binary) << OddGlb(*bytes, cut, blanks);
      const auto mesh = ImportMesh(file);
      ASSERT_TRUE(mesh) << mesh.error().message;
      EXPECT_EQ(AreaOf(*mesh), AreaOf(*whole));
      EXPECT_EQ(mesh->findings.CountOf("chunk whose size is no multiple of 4"), 1U);
      EXPECT_EQ(whole->findings.CountOf("chunk whose size is no multiple of 4"), 0U);
    }
    // The other chunk lies elsewhere.
    const auto file = test::FreshFolder() / "odd.glb";
    std::ofstream(file, std::ios::binary) << OddGlb(*bytes, cut, 7);
    const auto mesh = ImportMesh(file);
    ASSERT_FALSE(mesh);
    EXPECT_THAT(mesh.error().message, HasSubstr("odd.glb"));
    EXPECT_THAT(mesh.error().message, HasSubstr("no multiple of 4"));
  }
}

// The import library took as much memory as the chunk declares.
TEST(MeshesOfOthers, AChunkLargerThanItsGlbIsRefusedByItsSize) {
  const auto bytes = io::ReadWholeFile(kFolder + "skin.glb", 1 << 20);
  ASSERT_TRUE(bytes);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes->data() + 12, 4);
  for (const std::size_t at : {std::size_t{12}, std::size_t{20} + size}) {
    std::string glb = *bytes;
    glb[at + 3] = '\x80';
    const auto mesh = ImportMeshFromMemory(std::as_bytes(std::span(glb)), "glb");
    ASSERT_FALSE(mesh);
    EXPECT_THAT(mesh.error().message, HasSubstr("chunk has 21474"));
  }
}

std::vector<std::string> WarnedOf(const ImportedMesh& mesh) {
  std::vector<std::string> texts;
  for (const Warning& warning : WarningsOf("m", mesh.findings)) {
    if (warning.weight == WarningWeight::kWarning) texts.push_back(warning.text);
  }
  return texts;
}

Result<ImportedMesh> Read(const std::string& text, std::string_view extension) {
  return ImportMeshFromMemory(std::as_bytes(std::span(text)), extension);
}

TEST(MeshesOfOthers, APoseThatIsNotObeyedIsWarnedOf) {
  const auto skin = ImportMesh(kFolder + "skin.glb");
  const auto morph = ImportMesh(kFolder + "morph.glb");
  ASSERT_TRUE(skin && morph);
  EXPECT_THAT(WarnedOf(*skin),
              ElementsAre(HasSubstr("1 x skin (mesh meshes[0]): not obeyed")));
  EXPECT_THAT(WarnedOf(*morph), ElementsAre(HasSubstr("1 morph target")));
  // Without a weight a target changes nothing, and that is no warning.
  std::ifstream file(kFolder + "morph.glb");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text.replace(text.find("\"weights\": [1]") + 12, 1, "0");
  const auto unchanged = Read(text, "glb");
  ASSERT_TRUE(unchanged) << unchanged.error().message;
  EXPECT_THAT(WarnedOf(*unchanged), IsEmpty());
  EXPECT_EQ(unchanged->findings.CountOf("morph target without a weight"), 1u);
  // A node may have the weights in the place of its mesh; the text keeps its length.
  const auto replace = [&text](std::string_view old, std::string_view by) {
    text.replace(text.find(old), old.size(), by);
  };
  replace(", \"weights\": [0]", "");
  replace("{\"mesh\": 0}", "{\"mesh\":0,\"weights\":[5]}   ");
  const auto of_node = Read(text, "glb");
  ASSERT_TRUE(of_node) << of_node.error().message;
  EXPECT_THAT(WarnedOf(*of_node), ElementsAre(HasSubstr("1 morph target")));
}

// An extension that hides nodes need not be required.
TEST(MeshesOfOthers, HiddenNodesAreWarnedOf) {
  const std::string json =
      "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_node_visibility\"],"
      "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"extensions\":"
      "{\"KHR_node_visibility\":{\"visible\":false}}}],\"meshes\":[{\"primitives\":[{"
      "\"attributes\":{\"POSITION\":0}}]}],\"buffers\":[{\"byteLength\":36,\"uri\":"
      "\"data:application/"
      "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AA"
      "AAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{"
      "\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]}";
  const auto hidden = Read(json, "gltf");
  ASSERT_TRUE(hidden) << hidden.error().message;
  EXPECT_THAT(WarnedOf(*hidden), ElementsAre(HasSubstr("KHR_node_visibility")));
}

TEST(MeshesOfOthers, VerticesOfNoFaceAreWarnedOf) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nv 6 6 6\nf 1 2 3\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
      "end_header\n0 0 0\n1 0 0\n0 1 0\n5 5 5\n6 6 6\n3 0 1 2\n";
  for (const auto& mesh : {Read(obj, "obj"), Read(ply, "ply")}) {
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->vertices.size(), 3u);
    EXPECT_THAT(WarnedOf(*mesh),
                ElementsAre(AllOf(HasSubstr("2 vertices that belong to no face"),
                                  HasSubstr("vertex 4 of 5"))));
  }
  const auto line = Read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n", "obj");
  ASSERT_TRUE(line);
  EXPECT_THAT(WarnedOf(*line), ElementsAre(HasSubstr("1 x l (line 5): left out")));
  EXPECT_THAT(WarnedOf(*ImportMesh(kFolder + "notch.obj")), IsEmpty());
}

// The other scene.bin of the working directory would make another model.
TEST(MeshesOfOthers, NoFileOfTheWorkingDirectoryIsTaken) {
  const auto before = std::filesystem::current_path();
  const std::filesystem::path folder = test::FreshFolder();
  std::ofstream(folder / "scene.bin") << std::string(1000, '\0');
  std::filesystem::current_path(folder);
  const auto mesh = ImportMesh(kFolder + "two_files/scene.gltf");
  std::filesystem::current_path(before);
  EXPECT_FALSE(mesh);
}

TEST(Polygon, TrianglesHaveItsArea) {
  // A comb of 50 teeth: every second tooth of the upper side is a notch.
  PointList comb;
  for (int i = 0; i <= 50; ++i) comb.emplace_back(i, 0, 0);
  for (int i = 50; i >= 0; --i) comb.emplace_back(i, i % 2 == 0 ? 10 : 1, 0);
  const auto triangles = TriangulatePolygon(comb);
  ASSERT_TRUE(triangles);
  EXPECT_EQ(triangles->size(), comb.size() - 2);
  double area = 0;
  for (const auto& [a, b, c] : *triangles) {
    const Vec3 twice = (comb[b] - comb[a]).cross(comb[c] - comb[a]);
    EXPECT_GE(twice.z(), 0);
    area += twice.z() / 2;
  }
  EXPECT_NEAR(area, 50 * 5.5, 1e-9);
  const PointList bow = {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 3, 0}};
  EXPECT_FALSE(TriangulatePolygon(bow));
}

// The scans of Stanford are strips: a box of 12 triangles in two of them.
TEST(PlyFile, TriangleStripsAreAllTheirTriangles) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
      "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n";
  const auto read = [](const std::string& text) {
    return ImportMeshFromMemory(std::as_bytes(std::span(text)), "ply");
  };
  const auto mesh = read(header + "9 0 1 2 3 4 -1 0 1 2\n");
  ASSERT_TRUE(mesh) << mesh.error().message;
  ASSERT_EQ(mesh->triangles.size(), 4U);
  EXPECT_DOUBLE_EQ(AreaOf(*mesh), 2);
  for (const Triangle& t : mesh->triangles) {
    const Vec3& a = mesh->vertices[t[0]];
    EXPECT_GT((mesh->vertices[t[1]] - a).cross(mesh->vertices[t[2]] - a).z(), 0);
  }
  EXPECT_FALSE(read(header + "3 0 1 9\n"));
  EXPECT_FALSE(read(header + "4 0 1 2\n"));
}

// Each statement of the OBJ manual is read, left out as one without faces, or refused.
TEST(ObjFile, EveryStatementIsReadOrRefused) {
  const std::string box = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto read = [](const std::string& text) {
    return ImportMeshFromMemory(std::as_bytes(std::span(text)), "obj");
  };
  for (const char* line :
       {"vt 0 0", "vn 0 0 1", "vp 0 0", "p 1", "l 1 2", "s off", "mg 1 1", "o a", "g a b",
        "mtllib a.mtl", "usemtl a", "lod 1", "bevel on", "# note", "call a.obj"}) {
    const auto mesh = read(box + line + "\n");
    ASSERT_TRUE(mesh) << line << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), 1U) << line;
  }
  for (const char* line : {"curv 0 1 1 2", "curv2 1 2", "surf 0 1 0 1 1 2 3",
                           "trim 0 1 1", "hole 0 1 1", "scrv 0 1 1", "sp 1"}) {
    const auto mesh = read(box + line + "\n");
    ASSERT_FALSE(mesh) << line;
    EXPECT_EQ(mesh.error().code, ErrorCode::kUnsupported) << line;
  }
  for (const char* line : {"w 1", "f 1 2 9", "f 1 2 x", "f 1 2 0", "v 1 2", "f 1 -9 2"}) {
    const auto mesh = read(box + line + "\n");
    ASSERT_FALSE(mesh) << line;
    EXPECT_THAT(mesh.error().message, HasSubstr("line 5")) << line;
  }
}

}  // namespace
}  // namespace intaglio::mesh
