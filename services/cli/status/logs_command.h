#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio logs`: what the services of a shop have logged, of all or of one job.
void AddLogsCommand(command_line::Command app);

}  // namespace intaglio::cli
