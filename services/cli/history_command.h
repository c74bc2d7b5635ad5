#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio history`: what a shop has made.
void AddHistoryCommand(command_line::Command app);

}  // namespace intaglio::cli
