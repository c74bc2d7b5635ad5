#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// The commands that talk to a running shop: submit, list, show, watch, arm, pause,
/// resume, cancel.
void AddJobsCommands(command_line::Command app);

}  // namespace intaglio::cli
