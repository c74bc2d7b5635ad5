#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// `intaglio measure`: what a cloud of points is worth. Ends with 1 when it does not keep
/// the minimum spacing.
void AddMeasureCommand(command_line::Command app);

}  // namespace intaglio::cli
