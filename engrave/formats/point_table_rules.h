#pragma once

#include "engrave/formats/point_file.h"

namespace intaglio::formats {

/// Throws PreconditionError unless the table can be written and read back.
void RequireWritable(const PointTable& table);

/// Puts the file's name before an error of a parser.
Error AboutFile(Error error, const std::filesystem::path& file);

}  // namespace intaglio::formats
