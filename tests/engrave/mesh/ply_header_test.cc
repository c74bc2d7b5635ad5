#include "engrave/mesh/ply_header.h"

#include <gmock/gmock.h>

#include <string>

#include "engrave/mesh/mesh_import.h"
#include "tests/engrave/mesh/handmade_files.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

/// A box whose header has these lines more, at its beginning and before its end.
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

TEST(PlyHeader, NamesItsListsAsTheLibrarySeesThem) {
  const std::string header =
      "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 8\nproperty float x\r\n\t "
      "element  face\t12 \felement edge 3\nelement 7\nelement row9 0";
  const auto lists = PlyListsOf(header);
  ASSERT_EQ(lists.size(), 5u);
  const std::pair<std::string_view, std::uint64_t> expected[] = {
      {"vertex", 8}, {"face", 12}, {"edge", 3}, {"7", 7}, {"row9", 0}};
  for (std::size_t i = 0; i < lists.size(); ++i) {
    EXPECT_EQ(lists[i].name, expected[i].first);
    EXPECT_EQ(lists[i].row_count, expected[i].second) << lists[i].line;
  }
}

TEST(PlyHeader, RowsThatTheFileHasNoBytesForAreRefusedWhereverTheyHide) {
  for (const std::string& lines :
       {"element vertex 2000000000\n"s, "element 2000000000\n"s,
        "element 99999999999999999999\n"s, "element row 2000000000\n"s,
        "obj_info a\felement face 2000000000\n"s,
        "obj_info a\0element face 2000000000\n"s,
        "obj_info a\relement\tedge 2000000000\n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      const auto mesh = Import(ply);
      ASSERT_FALSE(mesh) << lines;
      EXPECT_EQ(mesh.error().code, ErrorCode::kUnreadable);
      EXPECT_THAT(mesh.error().message, HasSubstr("bytes, too few for \""));
    }
  }
}

// The library writes the rows of the second one behind its array.
TEST(PlyHeader, ASecondListOfAKindIsRefusedWhereverItHides) {
  for (const std::string& lines :
       {"element vertex 2\n"s, "obj_info a\felement vertex 2\n"s,
        "obj_info a\0\telement face 1\n"s, "obj_info a\0element tristrips 1\n"s}) {
    for (const std::string& ply : BoxesWith(lines)) {
      const auto mesh = Import(ply);
      ASSERT_FALSE(mesh) << lines;
      EXPECT_EQ(mesh.error().code, ErrorCode::kUnreadable);
      EXPECT_THAT(mesh.error().message, HasSubstr("its header declares"));
    }
  }
}

TEST(PlyHeader, WhatPeopleWriteInCommentsIsNoList) {
  for (const char* line :
       {"comment vertex 2000000000\n", "comment 20240101\n", "comment\n",
        "comment element vertex 2000000000\n", "obj_info element face 2000000000\n",
        "comment TextureFile a.png\n"}) {
    for (const std::string& ply : BoxesWith(line)) {
      const auto mesh = Import(ply);
      ASSERT_TRUE(mesh) << line << mesh.error().message;
      EXPECT_EQ(mesh->triangles.size(), 12u) << line;
    }
  }
}

}  // namespace
}  // namespace intaglio::mesh
