#pragma once

#include <cstddef>
#include <string_view>

namespace intaglio::io {

/// How many edits make `b` of `a`: bytes inserted, deleted, exchanged, and neighbours
/// that change places, no byte more than once (optimal string alignment: Damerau 1964,
/// restricted). Symmetric. For suggesting the names that a typing mistake may have meant.
std::size_t EditDistance(std::string_view a, std::string_view b);

}  // namespace intaglio::io
