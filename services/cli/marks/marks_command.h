#pragma once

// `intaglio marks`: what a job of marks becomes, before a machine marks it.

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

void AddMarksCommand(command_line::Command app);

}  // namespace intaglio::cli
