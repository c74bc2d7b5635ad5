#pragma once

// The velocity at each point of a path whose ticks are known (tick_labels.h): inside the
// boxes, so that every step stays feasible, and of those the velocities with the least
// acceleration.

#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/step_limits.h"
#include "engrave/motion/tick_labels.h"

namespace intaglio::motion {

/// Writes the velocity at the end of each step to `ends_mm_s`, mm/s; the last one is in
/// the last box. Each step keeps its choice of `choices`. `near_walls` as for
/// TickLabels::Choose. `sweeps` >= 0: passes that
/// lower the integral of the squared acceleration; after 2 there is less than 2 % left to
/// gain.
void ChooseSpeeds(const Vec3& start_mm_s, std::span<const Vec3> steps_mm,
                  std::span<const TimedStep> timed, bool near_walls,
                  const std::vector<StepLimits>& choices, double rate_hz, int sweeps,
                  std::vector<Vec3>& ends_mm_s);

}  // namespace intaglio::motion
