#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --clock-drift and --line-jitter.
void AddClockFlags(command_line::Command command, double& clock_drift_ppm,
                   double& line_jitter_ms);

}  // namespace intaglio::cli
