#include "engrave/mesh/files/ply_check.h"

#include <gmock/gmock.h>

#include <string>

#include "engrave/mesh/import/mesh_import.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

/// A box whose header has these additional lines, at its beginning and before its end.
std::vector<std::string> BoxesWith(const std::string& lines) {
  const std::string box = Ply(BoxMesh(Vec3(1, 2, 3)));
  std::string early = box, late = box;
  early.insert(early.find("element"), lines);
  late.insert(late.find("end_header"), lines);
  return {early, late};
}

Result<TriangleMesh> Import(const std::string& ply) {
  return ImportMeshFromMemory(std::as_bytes(std::span(ply.data(), ply.size())), "ply", {},
                              "box");
}

void ExpectRefused(const std::string& ply, const std::string& lines, const char* part) {
  const auto mesh = Import(ply);
  ASSERT_FALSE(mesh) << lines;
  EXPECT_EQ(mesh.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(mesh.error().message, HasSubstr(part)) << lines;
}

TEST(PlyCheck, RowsThatTheFileHasNoBytesForAreRefused) {
  for (const std::string& lines :
       {"element vertex 2000000000\n"s, "element 2000000000 0\n"s,
        "element 99999999999999999999 0\n"s, "element row 2000000000\n"s,
        "\t element  row\t99999999999999999999 \n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      ExpectRefused(ply, lines, "bytes, too few for \"element ");
    }
  }
}

TEST(PlyCheck, RowsBehindTheDeclaredOnesAreRefused) {
  const std::string box = Ply(BoxMesh(Vec3(1, 2, 3)));
  ASSERT_TRUE(Import(box + "\n \r\n"));
  ExpectRefused(box + "3 0 1 2\n", "", "goes on behind its last row");
}

// The library takes each of these for the end of a line, and what follows for another.
TEST(PlyCheck, DeclarationsThatOnlyTheLibrarySeesAreRefused) {
  for (const std::string& lines :
       {"obj_info a\felement face 2000000000\n"s,
        "obj_info a\0element face 2000000000\n"s,
        "obj_info a\relement\tedge 2000000000\n"s, "comment a\felement vertex 2\n"s,
        "obj_info a\0\telement face 1\n"s, "obj_info a\0element tristrips 1\n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      ExpectRefused(ply, lines, "control characters inside a line");
    }
  }
}

TEST(PlyCheck, LinesThatAreNotOfAHeaderAreRefused) {
  for (const std::string& lines :
       {"element 2000000000\n"s, "vertex 8\n"s, "element vertex eight\n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      ExpectRefused(ply, lines, "is not a line of a PLY header");
    }
  }
}

// The library writes the rows of the second one behind its array.
TEST(PlyCheck, ASecondListOfAKindIsRefused) {
  for (const std::string& lines :
       {"element vertex 2\n"s, "element face 1\n"s, "element tristrips 1\n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      ExpectRefused(ply, lines, "its header declares");
    }
  }
}

TEST(PlyCheck, LineEndsOfWindowsAreNoControlCharacters) {
  std::string ply = Ply(BoxMesh(Vec3(1, 2, 3)));
  for (std::size_t at = ply.find('\n'); at != std::string::npos;
       at = ply.find('\n', at + 2)) {
    ply.insert(at, "\r");
  }
  const auto mesh = Import(ply);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 12u);
}

TEST(PlyCheck, WhatPeopleWriteInCommentsIsNoList) {
  for (const char* line :
       {"comment vertex 2000000000\n", "comment 20240101\n", "comment\n",
        "comment element vertex 2000000000\n", "obj_info element face 2000000000\n",
        "comment TextureFile a.png\n", "element row9 0\n"}) {
    for (const std::string& ply : BoxesWith(line)) {
      const auto mesh = Import(ply);
      ASSERT_TRUE(mesh) << line << mesh.error().message;
      EXPECT_EQ(mesh->triangles.size(), 12u) << line;
    }
  }
}

}  // namespace
}  // namespace intaglio::mesh
