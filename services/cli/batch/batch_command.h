#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio batch`: a list of jobs, over the machines of a shop.
void AddBatchCommand(command_line::Command app);

}  // namespace intaglio::cli
