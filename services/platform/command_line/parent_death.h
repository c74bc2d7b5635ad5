#pragma once

#include <sys/types.h>

#include "services/platform/command_line/program.h"

namespace intaglio::command_line {

/// --die-with-parent[=PID]: 0 none, -1 whoever started this process, else that process.
void AddParentFlag(Command app, int& starter);

/// From now on this process ends (SIGTERM) with the one that started it, when the flag
/// was given. `parent`: getppid() at the beginning of main. False: it has ended already.
bool EndWithParent(int starter, pid_t parent);

}  // namespace intaglio::command_line
