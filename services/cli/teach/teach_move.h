#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `jog`, `move`, `to-zero` and `home` below `teach`.
void AddMoveCommands(command_line::Command teach);

}  // namespace intaglio::cli
