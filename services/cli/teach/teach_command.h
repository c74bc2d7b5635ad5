#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio teach`: moves a machine by hand and teaches its zeros and positions.
void AddTeachCommand(command_line::Command app);

}  // namespace intaglio::cli
