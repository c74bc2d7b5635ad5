#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/findings.h"
#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"

namespace intaglio::mesh {

/// Refuses a glTF or GLB, by name, that cannot be read right by the import library:
/// kUnsupported when it requires an extension that changes the shape (glTF 2.0, 3.12) or
/// uses instancing, kUnreadable when a buffer is a file of its own, or a chunk larger
/// than the file. The findings are its morph targets, which the library leaves out.
Result<FileFindings> CheckGltf(const ImportSource& source, std::string_view file);

/// A GLB whose first chunk has a size that is no multiple of 4 (against glTF 2.0, 4.4.3),
/// as old programs wrote it, with blanks behind that chunk: the import library rounds its
/// end up. The chunk of points begins behind it or at the next multiple of 4, whichever
/// has its head; kUnreadable where both or none has. Nothing: the file is aligned.
Result<std::optional<std::string>> AlignedGlb(const ImportSource& source,
                                              std::string_view file);

}  // namespace intaglio::mesh
