#include "engrave/mesh/mesh_formats.h"

#include <algorithm>
#include <string>

#include "engrave/io/lower_case.h"

namespace intaglio::mesh {

bool MayDeclareUnit(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  return lower == "dae" || lower == "3mf";
}

bool IsReadByProcess(std::string_view extension) {
  const std::string lower = io::LowerCaseExtension(extension);
  return lower != "stl" && std::find(kMeshExtensions.begin(), kMeshExtensions.end(),
                                     lower) != kMeshExtensions.end();
}

}  // namespace intaglio::mesh
