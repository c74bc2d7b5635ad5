#pragma once

#include <string>

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --console[=PORT]: `port` is that of a web console, "0" a free one, empty none. A text,
/// because a flag that is a number is counted: it begins at 0, and 0 counts as "no".
void AddConsoleFlag(command_line::Command command, std::string& port);

/// A value of ServiceSetOptions::console_port: -1 without a console.
int ConsolePortOf(const std::string& port);

}  // namespace intaglio::cli
