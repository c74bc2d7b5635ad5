#include "services/cli/flags/clock_flags.h"

namespace intaglio::cli {

void AddClockFlags(command_line::Command command, double& clock_drift_ppm,
                   double& line_jitter_ms) {
  command
      .AddOption("--clock-drift", clock_drift_ppm,
                 "the virtual stage runs on a clock of its own, this much too fast, ppm; "
                 "0: on the laser's ticks")
      .Within(-200.0, 200.0);
  command
      .AddOption("--line-jitter", line_jitter_ms,
                 "what is said on a serial line arrives up to this much later, ms")
      .Within(0.0, 2.0);
}

}  // namespace intaglio::cli
