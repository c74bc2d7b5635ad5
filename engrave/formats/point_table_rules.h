#pragma once

#include "engrave/formats/point_file.h"

namespace intaglio::formats {

/// Throws PreconditionError unless the table can be written and read back.
void RequireWritable(const PointTable& table);

/// A comment as a table may hold it: with blanks for the carriage returns inside it.
std::string OneLine(std::string_view comment);

/// Parses the content of a file; errors name it.
Result<PointTable> ReadAndParse(const std::filesystem::path& file,
                                const PointFileLimits& limits,
                                Result<PointTable> (*parse)(std::string_view,
                                                            const PointFileLimits&));

}  // namespace intaglio::formats
