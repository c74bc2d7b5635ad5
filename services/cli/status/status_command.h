#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// intaglio status: machines, jobs, alarms and disks of a shop in one screen.
void AddStatusCommand(command_line::Command app);

}  // namespace intaglio::cli
