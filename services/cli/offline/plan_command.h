#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// Commands that make or take a path, without services: sort, plan.
void AddPathCommands(command_line::Command app);

}  // namespace intaglio::cli
