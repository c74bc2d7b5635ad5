#include "services/cli/flags/truth_flags.h"

#include "engrave/core/try.h"
#include "services/virtual_engraver/truth/truth_file.h"

namespace intaglio::cli {

Status TruthFlags::Change(MachineTruth& truth) const {
  if (warm_up_s >= 0) truth.mutable_laser()->set_warm_up_s(warm_up_s);
  if (clock_drift_ppm != 0) truth.mutable_stage()->set_clock_drift_ppm(clock_drift_ppm);
  if (line_jitter_ms != 0) truth.set_line_jitter_ms(line_jitter_ms);
  if (file.empty()) return {};
  const auto changes = INTAGLIO_TRY(ReadTruthFile(file));
  Replace(changes, truth);
  return {};
}

void AddTruthFlags(command_line::Command command, TruthFlags& flags) {
  command.AddOption("--truth", flags.file,
                    "truth file: fields of the virtual machine that differ from what "
                    "follows from the profile");
  command
      .AddOption("--warm-up", flags.warm_up_s,
                 "lamp warm-up, s, instead of the profile's")
      .Within(0.0, 3600.0);
  command
      .AddOption("--clock-drift", flags.clock_drift_ppm,
                 "the virtual stage runs on its own clock, fast by this, ppm; 0: on the "
                 "laser's ticks")
      .Within(-200.0, 200.0);
  command
      .AddOption("--line-jitter", flags.line_jitter_ms,
                 "every message on a serial line arrives up to this much later, ms")
      .Within(0.0, 2.0);
}

}  // namespace intaglio::cli
