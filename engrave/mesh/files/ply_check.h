#pragma once

// Checks what a PLY's header declares before the import library reads the file, because
// the library does not check any of these numbers.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"

namespace intaglio::mesh {

/// More than any header of a PLY.
inline constexpr std::size_t kMaxPlyHeaderSize = 1 << 20;

/// kUnreadable when it is not the header of a PLY (io::ParsePlyHeader), when the library
/// would read it otherwise, when a list has more rows than the file has bytes, or when
/// there are two of vertices, or of faces. `beginning`: the file of `byte_count` bytes,
/// or its first kMaxPlyHeaderSize.
Status CheckPlyHeader(const ImportSource& source, std::string_view beginning,
                      std::uint64_t byte_count);

}  // namespace intaglio::mesh
