#pragma once

// How the virtual engraver differs from the machine profile.

#include <string>

#include "engrave/core/result.h"
#include "proto/truth.pb.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct TruthFlags {
  std::string file;            ///< empty: none
  double warm_up_s = -1;       ///< -1: the profile's
  double clock_drift_ppm = 0;  ///< 0: the stage counts the laser's ticks
  double line_jitter_ms = 0;

  /// Puts the flags into `truth`, then what the file sets. The errors are those of
  /// ReadTruthFile.
  Status Change(MachineTruth& truth) const;
};

/// --truth, --warm-up, --clock-drift and --line-jitter.
void AddTruthFlags(command_line::Command command, TruthFlags& flags);

}  // namespace intaglio::cli
