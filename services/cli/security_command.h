#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio security`: makes and renews identities, and lists the permissions of each
/// role.
void AddSecurityCommand(command_line::Command app);

}  // namespace intaglio::cli
