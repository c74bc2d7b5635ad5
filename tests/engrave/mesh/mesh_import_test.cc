#include "engrave/mesh/mesh_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <type_traits>
#include <utility>

#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/mesh/test_meshes.h"

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

template <typename T>
void Append(std::string& bytes, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string AsciiStl(const TriangleMesh& mesh) {
  std::string text = "solid box\n";
  for (const Triangle& t : mesh.triangles) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const auto corner : t) {
      const Vec3& v = mesh.vertices[corner];
      text += fmt::format("  vertex {} {} {}\n", v.x(), v.y(), v.z());
    }
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

std::string BinaryStl(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  Append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) Append(bytes, 0.0f);  // normal
    for (const auto corner : t) {
      for (int axis = 0; axis < 3; ++axis) {
        Append(bytes, static_cast<float>(mesh.vertices[corner][axis]));
      }
    }
    Append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string Obj(const TriangleMesh& mesh) {
  std::string text = "o box\n";
  for (const Vec3& v : mesh.vertices)
    text += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  // Another normal at each corner: the library splits the vertices by it.
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += fmt::format("vn 0 {} 1\nusemtl m{}\n", t, t % 3);
    const Triangle& c = mesh.triangles[t];
    text += fmt::format("f {}//{n} {}//{n} {}//{n}\n", c[0] + 1, c[1] + 1, c[2] + 1,
                        fmt::arg("n", t + 1));
  }
  return text;
}

std::string Ply(const TriangleMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) text += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
  for (const Triangle& t : mesh.triangles)
    text += fmt::format("3 {}\n", fmt::join(t, " "));
  return text;
}

std::string Dae(const TriangleMesh& mesh, const std::string& asset,
                const std::string& matrix) {
  std::string positions;
  for (const Vec3& v : mesh.vertices) {
    positions += fmt::format("{} {} {} ", v[0], v[1], v[2]);
  }
  std::string indices;
  for (const Triangle& t : mesh.triangles)
    indices += fmt::format("{} ", fmt::join(t, " "));
  return fmt::format(
      R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{}</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{}">{}</float_array><technique_common>
<accessor source="#a" count="{}" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/><p>{}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>{}</matrix>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
      asset, 3 * mesh.vertices.size(), positions, mesh.vertices.size(),
      mesh.triangles.size(), indices, matrix);
}

/// A glTF with its buffer inside, as base64, and a node transform (column by column).
std::string Gltf(const TriangleMesh& mesh, const std::string& matrix) {
  std::string buffer;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) Append(buffer, static_cast<float>(v[axis]));
  }
  const std::size_t index_offset = buffer.size();
  for (const Triangle& t : mesh.triangles) {
    for (const auto corner : t) Append(buffer, static_cast<std::uint16_t>(corner));
  }
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < buffer.size(); i += 3) {  // the size is a multiple of 3
    const auto byte = [&](std::size_t k) {
      return unsigned(std::uint8_t(buffer[i + k]));
    };
    const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += kDigits[bits >> shift & 63];
  }
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"mesh":0,"matrix":[{}]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{}}},
{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",
"min":[0,0,0],"max":[{},{},{}]}},
{{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}}]}})",
      matrix, buffer.size(), base64, index_offset, index_offset,
      buffer.size() - index_offset, mesh.vertices.size(), kSize.x(), kSize.y(), kSize.z(),
      3 * mesh.triangles.size());
}

/// A zip archive of stored (uncompressed) files.
std::string StoredZip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string zip;
  std::string directory;
  for (const auto& [name, content] : files) {
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(content.data()),
              static_cast<uInt>(content.size())));
    std::string common;  // the fields that both headers share
    for (const std::uint16_t field : {20, 0, 0, 0, 33}) Append(common, field);
    Append(common, crc);
    for (int i = 0; i < 2; ++i)
      Append(common, static_cast<std::uint32_t>(content.size()));
    Append(common, static_cast<std::uint16_t>(name.size()));
    Append(common, std::uint16_t{0});
    directory += "PK\1\2";
    Append(directory, std::uint16_t{20});
    directory += common;
    directory.append(10, '\0');
    Append(directory, static_cast<std::uint32_t>(zip.size()));
    directory += name;
    zip += "PK\3\4" + common + name + content;
  }
  const auto directory_offset = static_cast<std::uint32_t>(zip.size());
  zip += directory + "PK\5\6" + std::string(4, '\0');
  for (int i = 0; i < 2; ++i) Append(zip, static_cast<std::uint16_t>(files.size()));
  Append(zip, static_cast<std::uint32_t>(directory.size()));
  Append(zip, directory_offset);
  Append(zip, std::uint16_t{0});
  return zip;
}

/// A 3MF of one object, placed twice, with a picture (which the library mishandles).
std::string ThreeMf(const TriangleMesh& mesh, const std::string& unit,
                    const std::string& second_transform) {
  std::string vertices;
  for (const Vec3& v : mesh.vertices) {
    vertices += fmt::format(R"(<vertex x="{}" y="{}" z="{}"/>)", v[0], v[1], v[2]);
  }
  std::string triangles;
  for (const Triangle& t : mesh.triangles) {
    triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", t[0], t[1], t[2]);
  }
  const std::string packages = "http://schemas.openxmlformats.org/package/2006/";
  const std::string model = fmt::format(
      R"(<?xml version="1.0"?><model unit="{}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model"><mesh><vertices>{}</vertices><triangles>{}</triangles></mesh></object></resources><build><item objectid="1"/><item objectid="1" transform="{}"/></build></model>)",
      unit, vertices, triangles, second_transform);
  return StoredZip(
      {{"[Content_Types].xml",
        fmt::format(
            R"(<?xml version="1.0"?><Types xmlns="{}content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)",
            packages)},
       {"_rels/.rels",
        fmt::format(
            R"(<?xml version="1.0"?><Relationships xmlns="{}relationships"><Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)",
            packages)},
       {"3D/3dmodel.model", model},
       {"Metadata/thumbnail.png", "a picture of eleven thousand bytes"}});
}

/// The triangles as corner coordinates, each begun at its least corner, sorted.
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

constexpr char kIdentity[] = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

TEST(MeshImport, ReadsTheBoxFromEveryFormat) {
  const TriangleMesh box = BoxMesh(kSize);
  ExpectTheBox(Import(AsciiStl(box), "stl"), box);
  ExpectTheBox(Import(BinaryStl(box), ".STL"), box);
  ExpectTheBox(Import(Obj(box), "obj"), box);
  ExpectTheBox(Import(Ply(box), "ply"), box);
  ExpectTheBox(Import(Dae(box, "", kIdentity), "dae"), box);
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

TEST(MeshImport, DaeComesInMetresWithTheFilesAxes) {
  const auto mesh =
      Import(Dae(BoxMesh(kSize),
                 R"(<unit meter="0.001" name="mm"/><up_axis>Z_UP</up_axis>)", kIdentity),
             "dae");
  ASSERT_TRUE(mesh.has_value());
  // 0.001 is a float in the library: 1 part in 10^7.
  EXPECT_LT((mesh->Bounds().size_mm() - kSize * 1e-3).norm(), 1e-9);
}

TEST(MeshImport, ThreeMfKeepsItsUnitAndPlacesEachItem) {
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
  EXPECT_EQ(Surface(*mesh), Surface(expected)) << "in file units, inches are not applied";
  EXPECT_EQ(Diagnose(*mesh).component_count, 2u);
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

void ExpectError(const Result<TriangleMesh>& mesh, ErrorCode code, const char* part) {
  ASSERT_FALSE(mesh.has_value());
  EXPECT_EQ(mesh.error().code, code) << mesh.error().message;
  EXPECT_THAT(mesh.error().message, HasSubstr(part));
}

TEST(MeshImport, SaysWhatIsWrongWithBytes) {
  const std::string stl = BinaryStl(BoxMesh(kSize));
  ExpectError(Import("", "stl"), ErrorCode::kUnreadable, "box: the file is empty");
  ExpectError(Import(stl, "dxf"), ErrorCode::kUnsupported,
              "export it as one of stl, obj");
  ExpectError(Import(stl, ""), ErrorCode::kUnsupported, "");
  ExpectError(Import(stl.substr(0, stl.size() - 60), "stl"), ErrorCode::kUnreadable,
              "cannot be read as stl");
  ExpectError(Import("v 0 0 0\nv 1 0 0\nl 1 2\n", "obj"), ErrorCode::kMissing,
              "holds no triangles");
  ExpectError(Import("solid nothing\nendsolid nothing\n", "stl"), ErrorCode::kMissing,
              "holds no triangles");
}

TEST(MeshImport, RefusesCoordinatesThatAreNotFinite) {
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    TriangleMesh mesh = BoxMesh(kSize);
    mesh.vertices[5].y() = bad;
    ExpectError(Import(BinaryStl(mesh), "stl"), ErrorCode::kInvalidValue,
                "which is not a place");
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

TEST(MeshImport, ReadsAFileAndSaysWhatIsWrongWithOne) {
  const fs::path folder = fs::path(INTAGLIO_TEST_DIR) / "mesh_import";
  fs::create_directories(folder);
  const fs::path file = folder / "Box.STL";
  const TriangleMesh box = BoxMesh(kSize);
  const std::string stl = BinaryStl(box);
  std::ofstream(file, std::ios::binary) << stl;
  ExpectTheBox(ImportMesh(file), box);
  ExpectError(ImportMesh(folder / "absent.stl"), ErrorCode::kNotFound,
              "absent.stl: there is no such file");
  ExpectError(ImportMesh(folder), ErrorCode::kIo, "this is not a file");
  std::ofstream(folder / "empty.obj").flush();
  ExpectError(ImportMesh(folder / "empty.obj"), ErrorCode::kUnreadable, "is empty");
}

TEST(MeshImport, GivesTheSameMeshTwice) {
  const std::string obj = Obj(BoxMesh(kSize));
  const auto first = Import(obj, "obj");
  const auto second = Import(obj, "obj");
  EXPECT_EQ(first->vertices, second->vertices);
  EXPECT_EQ(first->triangles, second->triangles);
}

}  // namespace
}  // namespace intaglio::mesh
