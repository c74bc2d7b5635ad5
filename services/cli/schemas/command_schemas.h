#pragma once

// The JSON schemas of what commands and the console write and read, as they follow from
// the messages of proto/ with their comments and rules. The build writes them into
// docs/schemas of its tree.

#include <filesystem>
#include <map>
#include <string>

namespace intaglio::schemas {

/// By the name of the file, "report.schema.json": its text. `source_dir` holds proto/;
/// throws std::runtime_error with its place when a schema cannot be read.
std::map<std::string, std::string> CommandSchemas(
    const std::filesystem::path& source_dir);

}  // namespace intaglio::schemas
