#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio sheet use` and `intaglio sheet nest`: how much of a sheet its parts use, and
/// parts put on as few sheets as possible.
void AddSheetCommand(command_line::Command app);

}  // namespace intaglio::cli
