#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --console[=PORT]: `port` is that of a web console, 0 a free one, -1 none.
void AddConsoleFlag(command_line::Command command, int& port);

}  // namespace intaglio::cli
