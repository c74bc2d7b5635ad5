#pragma once

// One entry to all formats of points: the kind is taken from the file name's extension,
// in any case.
//
//   ply, xyz, txt (as xyz), cft, scl, dxf    read and written
//   gcode, nc, ngc                           written only, with the default options

#include <filesystem>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/formats/point_file.h"

namespace intaglio::formats {

/// The extensions as a sentence has them: "ply, xyz, ...".
std::string ReadablePointExtensions();
std::string WritablePointExtensions();

/// Errors as the format's reader has them, and kUnsupported, naming what there is, for
/// an extension of no known kind or a kind that is only written.
Result<PointTable> ReadPoints(const std::filesystem::path& file,
                              const PointFileLimits& limits = {});

/// The same for bytes in memory. `extension` is "ply", ".PLY" or the like.
Result<PointTable> ParsePoints(std::string_view bytes, std::string_view extension,
                               const PointFileLimits& limits = {});

/// Whether the name is one of a G-code file.
bool IsGcode(const std::filesystem::path& file);

/// kUnsupported before anything is written. What exists and is no regular file (a
/// terminal, a pipe) and has no extension is given XYZ text.
Status WritePoints(const std::filesystem::path& file, const PointTable& table);

}  // namespace intaglio::formats
