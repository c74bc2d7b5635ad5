#pragma once

#include <string>

#include "engrave/mesh/mesh_formats.h"

namespace intaglio::mesh_reader {

/// What the program does: reads the file that is its standard input, as the format of
/// `extension` and under `name`, and writes the answer
/// (services/job/models/mesh_answer.h) to its standard output. The exit code: 0 when that
/// is written, whatever the answer.
int ReadStandardInput(const std::string& extension, const std::string& name,
                      const mesh::ImportOptions& options);

}  // namespace intaglio::mesh_reader
