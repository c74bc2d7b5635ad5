#pragma once

// Which lengths of steps explain the measured times of the published machine
// (Trochimczuk 2008, annex F), under several models of a step. The object of the tables
// is not published, so the lengths are fitted: of each length on a grid the share of the
// steps, so that the sum of the squared differences to the 53 times is least.

#include <vector>

#include "tests/engrave/motion/published_tables.h"

namespace intaglio::motion {

/// What a step takes. A step is its longest axis, from rest to rest.
struct StepModel {
  /// The pulse is fired in the first tick at which the stage is this near; the next step
  /// begins there. 0: at its end.
  double window_mm = 0;
  double settling_s = 0;    ///< the rest behind a step, before its pulse
  double cycle_s = 0;       ///< a step takes whole cycles of the controller; 0: any time
  bool whole_ticks = true;  ///< false: a pulse is fired when the stage arrives
};

/// The time from a pulse to the next, s. distance_mm > 0.
double SecondsOf(const StepModel& model, double distance_mm, const MeasuredTime& row);

struct StepShare {
  double distance_mm = 0, share = 0;  ///< the shares of all lengths are 1 together
};

struct StepFit {
  std::vector<StepShare> steps;      ///< by ascending length, those with a share
  std::vector<double> difference_s;  ///< of each row, model less measured
  double rms_s = 0, largest_s = 0;   ///< largest_s: the magnitude
};

/// Fits 16179 steps of min_distance_mm (> 0) to 15 mm, each 3 % longer than the one
/// before.
StepFit FitSteps(const StepModel& model, double min_distance_mm,
                 const std::vector<MeasuredTime>& rows);

}  // namespace intaglio::motion
