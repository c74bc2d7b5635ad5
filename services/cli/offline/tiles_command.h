#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio tiles`: a cloud that is wider than the field of a scan head as jobs, one a
/// tile.
void AddTilesCommand(command_line::Command app);

}  // namespace intaglio::cli
