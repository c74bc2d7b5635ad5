#pragma once

// What a PLY's header declares, before the import library is let near it: that believes
// every word of it.

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/import_source.h"

namespace intaglio::mesh {

/// More than any header of a PLY.
inline constexpr std::size_t kMaxPlyHeaderSize = 1 << 20;

/// A list of rows: "element vertex 8".
struct PlyList {
  std::string_view line;
  std::string_view name;
  std::uint64_t row_count = 0;  ///< the greatest number when it is greater than that
};

/// Every list that the library may see declared in `header`.
std::vector<PlyList> PlyListsOf(std::string_view header);

/// kUnreadable when the header does not end, when a list has more rows than the file has
/// bytes, or when there are two of vertices, or of faces. `beginning`: the file of
/// `byte_count` bytes, or its first kMaxPlyHeaderSize.
Status CheckPlyHeader(const ImportSource& source, std::string_view beginning,
                      std::uint64_t byte_count);

}  // namespace intaglio::mesh
