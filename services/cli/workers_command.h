#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio workers`: lists the discretizers and sorters of a shop, and which of them
/// the job service has left out; below it `admit`.
void AddWorkersCommand(command_line::Command app);

}  // namespace intaglio::cli
