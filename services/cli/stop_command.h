#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// intaglio stop: the emergency stop of machines, over the bus.
void AddStopCommand(command_line::Command app);

}  // namespace intaglio::cli
