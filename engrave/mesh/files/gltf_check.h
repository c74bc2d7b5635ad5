#pragma once

#include <string_view>

#include "engrave/core/findings.h"
#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"

namespace intaglio::mesh {

/// Refuses a glTF or GLB, by name, that cannot be read right by the import library:
/// kUnsupported when it requires an extension that changes the shape (glTF 2.0, 3.12) or
/// uses instancing, kUnreadable when a buffer is a file of its own. The findings are its
/// morph targets, which the library leaves out.
Result<FileFindings> CheckGltf(const ImportSource& source, std::string_view file);

}  // namespace intaglio::mesh
