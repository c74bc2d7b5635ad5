#pragma once

// One entry to all formats of points: the kind is taken from the file name's extension,
// in any case.
//
//   ply, xyz, txt (as xyz), cft, scl, dxf

#include <filesystem>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/formats/point_file.h"

namespace intaglio::formats {

/// The extensions as written in a message: "ply, xyz, ...".
std::string PointExtensions();

/// One point or more. Errors are those of the format's reader, kMissing for a file
/// without points, and kUnsupported, naming the known kinds, for an unknown extension.
Result<PointTable> ReadPoints(const std::filesystem::path& file,
                              const PointFileLimits& limits = {});

/// The same for bytes in memory. `extension` is "ply", ".PLY" or the like.
Result<PointTable> ParsePoints(std::string_view bytes, std::string_view extension,
                               const PointFileLimits& limits = {});

/// kUnsupported before anything is written. An existing path that is not a regular file
/// (a terminal, a pipe) and has no extension gets XYZ text.
Status WritePoints(const std::filesystem::path& file, const PointTable& table);

}  // namespace intaglio::formats
