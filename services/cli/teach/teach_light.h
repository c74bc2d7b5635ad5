#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `teach lamp` and `teach shutter`: on for as long as the command runs.
void AddLightCommands(command_line::Command teach);

}  // namespace intaglio::cli
