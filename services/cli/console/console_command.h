#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio console`: who may log in to the web console of a shop.
void AddConsoleCommand(command_line::Command app);

}  // namespace intaglio::cli
