#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/mesh/files/declared_axis.h"
#include "engrave/mesh/import/mesh_import.h"
#include "engrave/mesh/mesh_diagnosis.h"

// The first byte picks the format ('0' stl, '1' obj, ... in the order below), the rest is
// the file. Every input gives a mesh of finite vertices or an error with a message. The
// import library itself is not instrumented.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  static constexpr std::array<std::string_view, 8> kExtensions = {
      "stl", "obj", "ply", "3mf", "gltf", "glb", "dae", "3ds"};
  if (size == 0) return 0;
  mesh::ImportOptions options;
  options.max_triangles = 100'000;
  const auto file = std::as_bytes(std::span(bytes, size)).subspan(1);
  const std::string_view extension = kExtensions[bytes[0] % kExtensions.size()];
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (const auto up = mesh::UpAxisOfFile(extension, text)) {
    Require(mesh::NearestUpAxis(mesh::DirectionOf(*up)) == *up, "an axis of no name");
  }
  const auto imported = mesh::ImportMeshFromMemory(file, extension, options);
  if (!imported) {
    Require(!imported.error().message.empty(), "an error without a sentence");
    return 0;
  }
  Require(!imported->triangles.empty(), "a mesh without triangles");
  for (const Vec3& v : imported->vertices) {
    Require(v.allFinite(), "a vertex that is not finite");
  }
  const mesh::MeshDiagnosis diagnosis = mesh::Diagnose(*imported);
  Require(diagnosis.vertex_count == imported->vertices.size(), "an unused vertex");
  return 0;
}
