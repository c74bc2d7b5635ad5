// Every element that the standard of 3MF and its extensions put into an object is read,
// warned of or refused: 3MF Core Specification 1.3, and the extensions production,
// materials, beam lattice, slice, volumetric, displacement, boolean operations, triangle
// sets and secure content.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "engrave/mesh/import/mesh_import.h"
#include "tests/engrave/mesh/handmade_files.h"

namespace intaglio::mesh {
namespace {

using ::testing::HasSubstr;

const std::string kThreeVertices =
    "<vertices><vertex x=' 0' y='0E0' z='\t0 '/><vertex x='+1.0E+00' y='0' z='0'/>"
    "<vertex x='0' y='1' z='0'/></vertices>";
const std::string kOneTriangle =
    "<triangles><triangle v1=' 0' v2='1 ' v3='2'/></triangles>";

Result<ImportedMesh> ReadPackage(const std::string& resources, const std::string& item,
                                 const std::string& attributes = "") {
  const std::string model =
      "<model xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02' " +
      attributes + "><resources>" + resources + "</resources><build>" + item +
      "</build></model>";
  const std::string file = Zip({{"3D/3dmodel.model", model}}, false);
  return ImportMeshFromMemory(std::as_bytes(std::span(file)), "3mf");
}

std::string Object(const std::string& inside) {
  return "<object id='1'>" + inside + "</object>";
}

/// Whether it is among the warnings.
bool IsWarned(const ImportedMesh& mesh, const std::string& name) {
  for (const FileFinding& finding : mesh.findings) {
    if (finding.what == name && finding.effect != Effect::kNothingSeen) return true;
  }
  return false;
}

TEST(ThreeMfGrammar, AnItemThatIsNotPrintableIsMadeAndWarnedOf) {
  const std::string object = Object("<mesh>" + kThreeVertices + kOneTriangle + "</mesh>");
  for (const auto& [attribute, is_warned] :
       {std::pair("printable='0'", true), std::pair("printable='1'", false),
        std::pair("", false)}) {
    const auto mesh =
        ReadPackage(object, std::string("<item objectid='1' ") + attribute + "/>");
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->triangles.size(), 1u);
    EXPECT_EQ(IsWarned(*mesh, "item that is not printable"), is_warned) << attribute;
  }
}

TEST(ThreeMfGrammar, TwoObjectsOfOneIdAreRefused) {
  const std::string object = Object("<mesh>" + kThreeVertices + kOneTriangle + "</mesh>");
  const auto mesh = ReadPackage(object + object, "<item objectid='1'/>");
  ASSERT_FALSE(mesh);
  EXPECT_THAT(mesh.error().message, HasSubstr("two objects 1"));
}

TEST(ThreeMfGrammar, NumbersMayHaveSpacesAroundThem) {
  const auto mesh =
      ReadPackage(Object("<mesh>" + kThreeVertices + kOneTriangle + "</mesh>"),
                  "<item objectid='1'/>");
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->triangles.size(), 1U);
  EXPECT_EQ(mesh->vertices.size(), 3U);
  for (const char* index : {"1.5", "-1", "3", "", "x", "1 2"}) {
    EXPECT_FALSE(ReadPackage(Object("<mesh>" + kThreeVertices +
                                    "<triangles><triangle v1='0' v2='1' "
                                    "v3='" +
                                    index + "'/></triangles></mesh>"),
                             "<item objectid='1'/>"))
        << index;
  }
}

TEST(ThreeMfGrammar, EveryElementOfAMeshIsReadWarnedOfOrRefused) {
  for (const char* element : {"vertices", "triangles", "t:trianglesets"}) {
    const auto mesh = ReadPackage(
        Object("<mesh>" + kThreeVertices + kOneTriangle + "<" + element + "/></mesh>"),
        "<item objectid='1'/>");
    ASSERT_TRUE(mesh) << element << mesh.error().message;
    EXPECT_TRUE(mesh->findings.empty()) << element;
  }
  const auto lattice = ReadPackage(Object("<mesh>" + kThreeVertices + kOneTriangle +
                                          "<b:beamlattice radius='1'/></mesh>"),
                                   "<item objectid='1'/>");
  ASSERT_FALSE(lattice);
  EXPECT_THAT(lattice.error().message, HasSubstr("beam lattice"));
  const auto other =
      ReadPackage(Object("<mesh>" + kThreeVertices +
                         "<triangles><triangle v1='0' v2='1' v3='2'/>"
                         "<other v1='0' v2='1' v3='2'/></triangles></mesh>"),
                  "<item objectid='1'/>");
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_EQ(other->triangles.size(), 1U);
  EXPECT_TRUE(IsWarned(*other, "element other"));
  for (const std::string element : {"b:balls", "v:volumedata", "x:anything"}) {
    const auto mesh = ReadPackage(
        Object("<mesh>" + kThreeVertices + kOneTriangle + "<" + element + "/></mesh>"),
        "<item objectid='1'/>");
    ASSERT_TRUE(mesh) << element << mesh.error().message;
    EXPECT_TRUE(IsWarned(*mesh, "element " + element)) << element;
  }
}

TEST(ThreeMfGrammar, EveryElementOfAnObjectIsReadWarnedOfOrRefused) {
  const std::string good =
      "<object id='2'><mesh>" + kThreeVertices + kOneTriangle + "</mesh></object>";
  const std::string items = "<item objectid='1'/><item objectid='2'/>";
  const auto components =
      ReadPackage(good + Object("<metadatagroup/><components><component objectid='2'/>"
                                "</components>"),
                  items);
  ASSERT_TRUE(components) << components.error().message;
  EXPECT_TRUE(components->findings.empty());
  EXPECT_EQ(components->triangles.size(), 2U);
  for (const std::string element : {"bo:booleanshape", "d:displacementmesh", "i:levelset",
                                    "p:alternatives", "x:anything"}) {
    const auto mesh = ReadPackage(good + Object("<" + element + "/>"), items);
    ASSERT_TRUE(mesh) << element << mesh.error().message;
    EXPECT_TRUE(IsWarned(*mesh, "element " + element)) << element;
    EXPECT_TRUE(IsWarned(*mesh, "object without a mesh")) << element;
  }
  // Slices alone are an attribute in the place of a mesh.
  const auto slices = ReadPackage(good + "<object id='1' s:slicestackid='3'/>", items);
  ASSERT_TRUE(slices) << slices.error().message;
  EXPECT_TRUE(IsWarned(*slices, "object without a mesh"));
}

TEST(ThreeMfGrammar, EveryExtensionThatIsRequiredIsReadOrRefused) {
  const std::string object = Object("<mesh>" + kThreeVertices + kOneTriangle + "</mesh>");
  const std::pair<const char*, bool> extensions[] = {
      {"production/2015/06", true},     {"material/2015/02", true},
      {"trianglesets/2021/07", true},   {"beamlattice/2017/02", false},
      {"slice/2015/07", false},         {"volumetric/2022/01", false},
      {"displacement/2022/07", false},  {"booleanoperations/2023/07", false},
      {"securecontent/2019/04", false}, {"implicit/2023/12", false}};
  for (const auto& [name, is_read] : extensions) {
    const auto mesh = ReadPackage(
        object, "<item objectid='1'/>",
        std::string("requiredextensions='x' xmlns:x='http://schemas/") + name + "'");
    EXPECT_EQ(mesh.has_value(), is_read) << name;
    if (!mesh) {
      EXPECT_THAT(mesh.error().message, HasSubstr(name));
    }
  }
}

}  // namespace
}  // namespace intaglio::mesh
