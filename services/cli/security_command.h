#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio security`: makes and renews identities, and says who may do what.
void AddSecurityCommand(command_line::Command app);

}  // namespace intaglio::cli
