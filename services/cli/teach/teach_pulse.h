#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `teach pulse` and `teach focus`: jobs of points at the present place, which a person
/// arms, and the zero by the first visible crack.
void AddTestPulseCommands(command_line::Command teach);

}  // namespace intaglio::cli
