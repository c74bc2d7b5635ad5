#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio up`: the services of a shop with one machine, or with several virtual
/// ones, until Ctrl-C.
void AddUpCommand(command_line::Command app);

}  // namespace intaglio::cli
