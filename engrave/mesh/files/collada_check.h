#pragma once

// What is read of a Collada file (.dae) beside the import library: index lists that the
// library would read for ever, accessors that reach behind their arrays, and the up axis.

#include <optional>
#include <string>
#include <string_view>

#include "engrave/mesh/up_axis.h"

namespace intaglio::mesh {

/// What is wrong, as the rest of "it cannot be read as dae (...)"; empty when nothing is.
/// Reads the tags as they are in the text, without parsing the XML: a file that hides its
/// numbers in entities is refused, too.
std::string WrongInCollada(std::string_view text);

/// The first up_axis of the text; Y_UP, the standard's default, when there is none or it
/// has another value than X_UP, Y_UP and Z_UP.
UpAxis UpAxisInCollada(std::string_view text);

/// mm that the file's unit of length is long (COLLADA 1.4.1, "unit"); nothing when it
/// declares none, or none that is positive.
std::optional<double> UnitInCollada_mm(std::string_view text);

}  // namespace intaglio::mesh
