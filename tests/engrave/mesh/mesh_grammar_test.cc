// Every statement of an OBJ (Wavefront Advanced Visualizer manual, appendix B1), every
// element of a PLY (Turk 1994, and what scanners and modellers add) and every word of an
// STL is read, warned of or refused: nothing that is seen in a viewer is lost in silence.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "engrave/mesh/import/mesh_import.h"

namespace intaglio::mesh {
namespace {

using ::testing::HasSubstr;

Result<ImportedMesh> Read(const std::string& text, const char* extension) {
  return ImportMeshFromMemory(std::as_bytes(std::span(text)), extension);
}

/// Whether something of this name is among the warnings.
bool IsWarned(const ImportedMesh& mesh, const std::string& name) {
  for (const FileFinding& finding : mesh.findings) {
    if (finding.what == name && finding.effect != Effect::kNothingSeen) return true;
  }
  return false;
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST(ObjGrammar, StatementsOfAppearanceLoseNothing) {
  for (const char* line : {"vt 0 0",
                           "vn 0 0 1",
                           "vp 0 0",
                           "s off",
                           "s 1",
                           "mg 1 2",
                           "mtllib a.mtl",
                           "usemtl red",
                           "maplib a",
                           "usemap off",
                           "bevel on",
                           "lod 3",
                           "shadow_obj a.obj",
                           "trace_obj a.obj",
                           "c_interp on",
                           "d_interp off",
                           "# a comment",
                           "",
                           "o name",
                           "g one two",
                           "g"}) {
    const auto mesh = Read(kTriangle + line + "\n", "obj");
    ASSERT_TRUE(mesh) << line << ": " << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), 1U) << line;
    EXPECT_TRUE(mesh->findings.empty()) << line;
  }
}

TEST(ObjGrammar, WhatIsSeenAndNoFaceIsWarnedOf) {
  for (const auto& [line, name] : {std::pair("p 1 2", "p"), std::pair("l 1 2 3", "l"),
                                   std::pair("call more.obj", "call"),
                                   std::pair("f 1 2", "f of fewer than three corners"),
                                   std::pair("f 1", "f of fewer than three corners")}) {
    const auto mesh = Read(kTriangle + line + "\n", "obj");
    ASSERT_TRUE(mesh) << line << ": " << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), 1U) << line;
    EXPECT_TRUE(IsWarned(*mesh, name)) << line;
  }
}

TEST(ObjGrammar, FreeFormsAreRefusedByName) {
  for (const char* statement : {"curv", "curv2", "surf", "trim", "hole", "scrv", "sp"}) {
    const auto mesh = Read(kTriangle + statement + " 0 1 1 2\n", "obj");
    ASSERT_FALSE(mesh) << statement;
    EXPECT_EQ(mesh.error().code, ErrorCode::kUnsupported) << statement;
    EXPECT_THAT(mesh.error().message, HasSubstr(statement));
    EXPECT_THAT(mesh.error().message, HasSubstr("line 5"));
  }
}

TEST(ObjGrammar, WhatNoObjHasIsRefusedWithItsLine) {
  for (const char* line : {"w 1 2 3", "v 0 0", "v a b c", "v 0 0 nan", "f 1 2 4",
                           "f 0 1 2", "f -4 -1 -2", "f 1 2 x", "f 1.5 2 3", "<html>"}) {
    const auto mesh = Read(kTriangle + line + "\n", "obj");
    ASSERT_FALSE(mesh) << line;
    EXPECT_THAT(mesh.error().message, HasSubstr("line 5")) << line;
  }
}

TEST(ObjGrammar, CornersAndVerticesHaveAllTheirForms) {
  for (const char* face :
       {"f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 2/2/2 3/3/3",
        "f -3 -2 -1", "f 1 2 \\\n3", "f  1\t2  3 # three", "fo 1 2 3"}) {
    for (const char* end : {"\n", "\r\n"}) {
      const auto mesh = Read("v 0 0 0 1" + std::string(end) +   // with a weight
                                 "v 1 0 0 0.5 0.5 0.5" + end +  // with a colour
                                 "v .0 1. 0e0" + end + face + end,
                             "obj");
      ASSERT_TRUE(mesh) << face << ": " << mesh.error().message;
      EXPECT_EQ(mesh->triangles.size(), 1U) << face;
      EXPECT_TRUE(mesh->findings.empty()) << face;
    }
  }
}

/// An ascii PLY of a triangle with more behind it.
std::string Ply(const std::string& header, const std::string& rows,
                const std::string& face = "3 0 1 2\n",
                const std::string& vertex =
                    "property float x\nproperty float y\n"
                    "property float z\n") {
  return "ply\nformat ascii 1.0\ncomment c\nobj_info i\nelement vertex 3\n" + vertex +
         "element face 1\nproperty list uchar int vertex_indices\n" + header +
         "end_header\n0 0 0\n1 0 0\n0 1 0\n" + face + rows;
}

TEST(PlyGrammar, EveryElementIsReadOrWarnedOf) {
  for (const char* unseen : {"material", "camera", "light"}) {
    const auto mesh = Read(
        Ply("element " + std::string(unseen) + " 1\nproperty float a\n", "1\n"), "ply");
    ASSERT_TRUE(mesh) << unseen << ": " << mesh.error().message;
    EXPECT_TRUE(mesh->findings.empty()) << unseen;
  }
  for (const std::string seen : {"edge", "polyline", "spline", "anything"}) {
    const auto mesh = Read(
        Ply("element " + seen + " 2\nproperty int a\nproperty int b\n", "0 1\n1 2\n"),
        "ply");
    ASSERT_TRUE(mesh) << seen << ": " << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), 1U) << seen;
    EXPECT_TRUE(IsWarned(*mesh, "element " + seen)) << seen;
  }
  const auto none = Read(Ply("element edge 0\nproperty int a\n", ""), "ply");
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_TRUE(none->findings.empty()) << "none are there";
  EXPECT_FALSE(
      Read(Ply("element range_grid 1\nproperty list uchar int i\n", "1 0\n"), "ply"));
}

TEST(PlyGrammar, FacesWithoutAnAreaAreWarnedOf) {
  const auto mesh = Read(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nelement face 3\n"
      "property list uchar int vertex_index\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n0\n",
      "ply");
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 1U);
  EXPECT_TRUE(IsWarned(*mesh, "face of fewer than three corners"));
}

TEST(PlyGrammar, VerticesHaveAllTheirCoordinates) {
  for (const auto& [vertex, missing] :
       {std::pair("property float x\nproperty float y\nproperty float w\n", "z"),
        std::pair("property float X\nproperty float y\nproperty float z\n", "x"),
        std::pair("property float x\nproperty float u\nproperty float z\n", "y")}) {
    const auto mesh = Read(Ply("", "", "3 0 1 2\n", vertex), "ply");
    ASSERT_FALSE(mesh) << vertex;
    EXPECT_THAT(mesh.error().message, HasSubstr(std::string("no property ") + missing));
  }
}

TEST(StlGrammar, EveryKeywordIsReadOrRefused) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\n";
  const auto two = Read(
      "solid a b c\n" + facet + "endsolid a b c\nSOLID\n" + facet + "EndSolid\n", "stl");
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_EQ(two->triangles.size(), 2U);
  for (const char* line : {"edge 0 0 0", "vertex 0 0 0", "color 1 0 0", "solid again",
                           "endfacet", "facet normal 0 0 1\nfacet normal 0 0 1"}) {
    EXPECT_FALSE(Read("solid a\n" + facet + line + "\nendsolid\n", "stl")) << line;
  }
  for (const char* vertex : {"vertex 0 0", "vertex a b c", "vertex 0 0 nan"}) {
    EXPECT_FALSE(
        Read("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
             "vertex 1 0 0\n" +
                 std::string(vertex) + "\nendloop\nendfacet\nendsolid\n",
             "stl"))
        << vertex;
  }
  EXPECT_FALSE(Read("solid a\n" + facet, "stl")) << "cut off";
}

}  // namespace
}  // namespace intaglio::mesh
