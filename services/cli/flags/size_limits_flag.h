#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --size-limits: the factor of services/job/models/read_limits.h.
void AddSizeLimitsFlag(command_line::Command command, double& factor);

/// The same for the programs that this one starts.
void HandOnSizeLimits(double factor);

}  // namespace intaglio::cli
