#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace intaglio::mesh {

/// The total unpacked size in bytes of the files of a zip archive by its central
/// directory, which is what an unpacker uses (PKWARE, "ZIP file format specification",
/// 4.3.12 and 4.3.16). Nothing when there is no whole directory; a file of 4 GiB or more
/// counts as 4 GiB.
std::optional<std::uint64_t> UnpackedSize(std::string_view archive);

}  // namespace intaglio::mesh
