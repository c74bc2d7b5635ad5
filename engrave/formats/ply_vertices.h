#pragma once

#include "engrave/formats/point_file.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/ply_values.h"

namespace intaglio::formats {

/// The rows of an element as points and columns. `rest_size`: bytes that `values` has.
/// Errors as ParsePly(), of the rows counted from the first that is read.
Result<PointTable> ReadVertices(const io::PlyElement& vertices, std::size_t rest_size,
                                io::PlyValues& values, const PointFileLimits& limits);

}  // namespace intaglio::formats
