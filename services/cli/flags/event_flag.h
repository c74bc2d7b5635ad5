#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --events.
void AddEventsFlag(command_line::Command command, bool& events);

}  // namespace intaglio::cli
