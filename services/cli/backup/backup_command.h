#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio backup` and `intaglio restore`: what a shop keeps, into one file and back.
void AddBackupCommands(command_line::Command app);

}  // namespace intaglio::cli
