#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// Commands that need no services: discretize, verify, render.
void AddOfflineCommands(command_line::Command app);

}  // namespace intaglio::cli
