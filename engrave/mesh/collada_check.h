#pragma once

// What the import library does not check of a Collada file (.dae) before it trusts it:
// index lists that it reads for ever, and accessors that reach behind their arrays.

#include <string>
#include <string_view>

namespace intaglio::mesh {

/// What is wrong, as the rest of "it cannot be read as dae (...)"; empty when nothing is.
/// Looks at the tags as they stand in the text, without reading the XML: a file that
/// hides its numbers in entities is refused, too.
std::string WrongInCollada(std::string_view text);

}  // namespace intaglio::mesh
