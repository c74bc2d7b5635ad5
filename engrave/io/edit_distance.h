#pragma once

#include <cstddef>
#include <string_view>

namespace intaglio::io {

/// The number of edits that turn `a` into `b`: bytes inserted, deleted or substituted,
/// and neighbours transposed, no byte more than once (optimal string alignment: Damerau
/// 1964, restricted). Symmetric. For suggesting the names that a typing mistake may have
/// meant.
std::size_t EditDistance(std::string_view a, std::string_view b);

}  // namespace intaglio::io
