#pragma once

// How exact the times of a stage's steps are on this computer: simulated outputs, motion
// by hand along x to and fro, and no line.

#include <functional>
#include <string>

#include "services/reference_controller/edge_record.h"
#include "services/reference_controller/stage_controller.h"

namespace intaglio::reference_controller {

struct StepJitter {
  double speed_mm_s = 0;  ///< that was commanded
  double period_us = 0;   ///< from a step to the next at that speed
  Spread period;          ///< as it was, where that speed is commanded
  double behind_mm = 0;   ///< the largest following error
  double limit_mm = 0;    ///< of it: beyond, a stage would have stopped
  std::size_t stops = 0;  ///< so often
};

/// At the largest speed of x; a stage that would have stopped goes on. Ends early once
/// `stops` is true. kRefused: it ended before there were steps to measure.
Result<StepJitter> MeasureSteps(StageControllerOptions options, double seconds,
                                const ControllerTime& time,
                                const std::function<bool()>& stops);
/// A table of lines that end with '\n'.
std::string ToText(const StepJitter& jitter);

}  // namespace intaglio::reference_controller
