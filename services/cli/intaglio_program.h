#pragma once

#include <memory>

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// The command intaglio with all its commands.
std::unique_ptr<command_line::Program> IntaglioProgram();

}  // namespace intaglio::cli
