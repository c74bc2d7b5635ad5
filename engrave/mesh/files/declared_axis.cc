#include "engrave/mesh/files/declared_axis.h"

#include <string>

#include "engrave/io/lower_case.h"
#include "engrave/mesh/files/collada_check.h"

namespace intaglio::mesh {

std::optional<UpAxis> UpAxisOfFile(std::string_view extension, std::string_view file) {
  const std::string lower = io::LowerCaseExtension(extension);
  if (lower == "gltf" || lower == "glb") return UpAxis::kY;
  if (lower == "dae") return UpAxisInCollada(file);
  return std::nullopt;
}

}  // namespace intaglio::mesh
