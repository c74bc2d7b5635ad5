#pragma once

// Checks of a Collada file (.dae) that the import library omits: index lists that it
// would read for ever, and accessors that reach behind their arrays.

#include <string>
#include <string_view>

namespace intaglio::mesh {

/// What is wrong, as the rest of "it cannot be read as dae (...)"; empty when nothing is.
/// Reads the tags as they are in the text, without parsing the XML: a file that hides its
/// numbers in entities is refused, too.
std::string WrongInCollada(std::string_view text);

}  // namespace intaglio::mesh
