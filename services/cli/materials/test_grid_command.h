#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio test-grid`: the job of a material test.
void AddTestGridCommand(command_line::Command app);

}  // namespace intaglio::cli
