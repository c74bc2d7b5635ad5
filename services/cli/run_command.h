#pragma once

#include "engrave/core/result.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio run`: engraves one job with a private set of processes, and proves it.
void AddRunCommand(command_line::Command app);

}  // namespace intaglio::cli
