#pragma once

// Warnings as people read them.

#include <string>

#include "engrave/core/warning.h"

namespace intaglio::client {

/// "note", "warning"; of one that a person has to accept its code, "breakage".
const char* LabelOf(const Warning& warning);

/// "warning    3 of 100 rays ...": aligned with the lines of a job.
std::string WarningLine(const Warning& warning);

}  // namespace intaglio::client
