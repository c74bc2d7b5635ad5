#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio replay`: puts a recording back on a bus.
void AddReplayCommand(command_line::Command app);

}  // namespace intaglio::cli
