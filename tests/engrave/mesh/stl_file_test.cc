#include "engrave/mesh/files/stl_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "engrave/mesh/mesh_diagnosis.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

Result<TriangleMesh> Read(const std::string& bytes, const ImportOptions& options = {}) {
  MemoryReader reader(bytes);
  return ReadStl(reader, bytes.size(), ImportSource{"box", "stl", options});
}

void ExpectError(const std::string& bytes, ErrorCode code, const char* part,
                 const ImportOptions& options = {}) {
  const auto mesh = Read(bytes, options);
  ASSERT_FALSE(mesh.has_value()) << bytes.substr(0, 200);
  EXPECT_EQ(mesh.error().code, code) << mesh.error().message;
  EXPECT_THAT(mesh.error().message, HasSubstr(part));
}

std::string Facet(const std::string& vertices) {
  return "facet normal 0 0 0\nouter loop\n" + vertices + "endloop\nendfacet\n";
}
constexpr char kCorners[] = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";

/// A torus of 2 * rings * sides triangles: closed, of Euler characteristic 0.
TriangleMesh Torus(std::uint32_t rings, std::uint32_t sides) {
  TriangleMesh mesh;
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const double u = 2 * M_PI * r / rings;
      const double v = 2 * M_PI * s / sides;
      const double out = 20 + 8 * std::cos(v);
      const auto x = static_cast<float>(out * std::cos(u));
      const auto y = static_cast<float>(out * std::sin(u));
      mesh.vertices.emplace_back(x, y, static_cast<float>(8 * std::sin(v)));
      const std::uint32_t next_r = (r + 1) % rings;
      const std::uint32_t next_s = (s + 1) % sides;
      mesh.triangles.push_back(
          {r * sides + s, next_r * sides + s, next_r * sides + next_s});
      mesh.triangles.push_back(
          {r * sides + s, next_r * sides + next_s, r * sides + next_s});
    }
  }
  return mesh;
}

TEST(StlFile, BothKindsGiveTheSameMeshOverManyReads) {
  // 30 000 triangles: several batches, reads of 20 000, and 5 megabytes of text.
  const TriangleMesh torus = Torus(150, 100);
  const auto binary = Read(BinaryStl(torus));
  ASSERT_TRUE(binary.has_value()) << binary.error().message;
  const auto text = Read(AsciiStl(torus));
  ASSERT_TRUE(text.has_value()) << text.error().message;
  EXPECT_EQ(binary->vertices, text->vertices);
  EXPECT_EQ(binary->triangles, text->triangles);
  ASSERT_EQ(binary->triangles.size(), torus.triangles.size());
  EXPECT_EQ(binary->vertices.size(), torus.vertices.size());
  for (std::size_t t = 0; t < torus.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(binary->vertices[binary->triangles[t][c]],
                torus.vertices[torus.triangles[t][c]]);
    }
  }
  EXPECT_TRUE(Diagnose(*binary).closed());
}

TEST(StlFile, ReadsTextsAsTheyAreWritten) {
  const std::string capitals =
      "SOLID Part 1\r\n  FACET NORMAL -nan(ind) 1.#QNAN 0\r\n OUTER LOOP\r\n\tVERTEX 0 0 "
      "0\r\n"
      "\tVERTEX +1.0E+0 0 0\r\n\tVERTEX 0 1e-400 1.e1\r\n ENDLOOP\r\n "
      "ENDFACET\r\nENDSOLID "
      "Part 1\r\n";
  const auto mesh = Read(capitals);
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  EXPECT_EQ(mesh->vertices, (PointList{{0, 0, 0}, {1, 0, 0}, {0, 0, 10}}));
  const std::string two_solids = "\xEF\xBB\xBF\n solid a\n" + Facet(kCorners) +
                                 "endsolid a\n\nsolid\n" + Facet(kCorners) + "endsolid";
  ASSERT_TRUE(Read(two_solids).has_value()) << Read(two_solids).error().message;
  EXPECT_EQ(Read(two_solids)->triangles.size(), 2u);
  const std::string on_one_line =
      "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 "
      "endloop "
      "endfacet\nendsolid\n";
  EXPECT_TRUE(Read(on_one_line).has_value());
}

TEST(StlFile, TakesTheNearestFloat) {
  // 0.1 and a number half way between two floats, which rounds to even.
  const auto mesh = Read("solid\n" +
                         Facet("vertex 0.1 0 16777217\nvertex 1e-46 1e-50 0\n"
                               "vertex 3.4028235e38 1 1\n") +
                         "endsolid\n");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  EXPECT_EQ(mesh->vertices[0], Vec3(double{0.1f}, 0, 16777216));
  EXPECT_EQ(mesh->vertices[1], Vec3(0, 0, 0));
  EXPECT_EQ(mesh->vertices[2].x(), double{std::numeric_limits<float>::max()});
}

TEST(StlFile, DistinguishesTextFromBinaryByTheSize) {
  std::string binary = BinaryStl(BoxMesh(Vec3(1, 2, 3)));
  binary.replace(0, 12, "solid of box");
  EXPECT_EQ(Read(binary)->triangles.size(), 12u);
  EXPECT_EQ(Read(binary + "pad")->triangles.size(), 12u);
  ExpectError(binary.substr(0, binary.size() - 1), ErrorCode::kUnreadable,
              "declares 12 triangles, its size allows 11");
  ExpectError(binary + std::string(50, '\0'), ErrorCode::kUnreadable,
              "its size allows 13");
  ExpectError("not an stl", ErrorCode::kUnreadable, "neither begins with \"solid\"");
}

TEST(StlFile, ReportsInWhichLineATextIsWrong) {
  const std::string good = Facet(kCorners);
  ExpectError("solid\n" + good, ErrorCode::kUnreadable, "after line 8 without endsolid");
  ExpectError("solid\n" + Facet("vertex 0 0 0\nvertex 1,5 0 0\n") + "endsolid\n",
              ErrorCode::kUnreadable, "line 5 is not a vertex: \"vertex 1,5 0 0\"");
  ExpectError("solid\n" + Facet("vertex 0 0 0\nvertex 1 0 0\n") + "endsolid\n",
              ErrorCode::kUnreadable, "line 7 ends a facet of 2 vertices");
  ExpectError("solid\n" + Facet(std::string(kCorners) + "vertex 1 1 0\n") + "endsolid\n",
              ErrorCode::kUnreadable, "line 7 has an extra vertex");
  ExpectError("solid\n" + good + "<html>\nendsolid\n", ErrorCode::kUnreadable,
              "line 9 is not a line of an STL: \"<html>\"");
  ExpectError("solid\nsolid\n" + good, ErrorCode::kUnreadable, "line 2 has a solid in");
  ExpectError("solid\nendsolid\n" + good, ErrorCode::kUnreadable,
              "line 3 begins a facet");
  ExpectError(
      "solid\n" + Facet("vertex 0 0 0\nvertex 1e99 0 0\nvertex 0 1 0\n") + "endsolid\n",
      ErrorCode::kInvalidValue, "is at (inf, 0, 0)");
  ExpectError("solid " + std::string(3 << 20, 'x'), ErrorCode::kUnreadable,
              "longer than a megabyte");
}

TEST(StlFile, KeepsTheLimitInATextToo) {
  ImportOptions options;
  options.max_triangles = 11;
  ExpectError(AsciiStl(BoxMesh(Vec3(1, 2, 3))), ErrorCode::kTooLarge, "the 11 triangles",
              options);
  options.max_triangles = 12;
  EXPECT_TRUE(Read(AsciiStl(BoxMesh(Vec3(1, 2, 3))), options).has_value());
}

TEST(StlFile, NamesTheTriangleWhoseCornerIsNowhere) {
  TriangleMesh torus = Torus(100, 100);
  std::string bytes = BinaryStl(torus);
  const float nowhere = std::nanf("");
  std::memcpy(bytes.data() + 84 + 50 * 15'000 + 12 + 16, &nowhere, 4);
  ExpectError(bytes, ErrorCode::kInvalidValue, "a corner of triangle 15000 is at (");
}

}  // namespace
}  // namespace intaglio::mesh
