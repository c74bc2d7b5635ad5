#pragma once

// Which axis a file itself calls up (up_axis.h says what the formats define).

#include <optional>
#include <string_view>

#include "engrave/mesh/up_axis.h"

namespace intaglio::mesh {

/// The axis that a file declares or its format defines, by the file name's extension, in
/// any case; nothing for a format that defines none. `file` is read for a .dae only.
std::optional<UpAxis> UpAxisOfFile(std::string_view extension, std::string_view file);

}  // namespace intaglio::mesh
