#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio materials list | show | add | replace | remove | import | export`: the
/// glasses that are known. Each returns kExitGood or kExitWrongInput, and prints the
/// error on the standard error stream.
void AddMaterialsCommand(command_line::Command app);

}  // namespace intaglio::cli
