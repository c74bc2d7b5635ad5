#pragma once

// The position tolerance is known in two places: the machine profile has it for the plan
// and the report, the stage controller decides by its own whether a pulse may be fired.
// They have to be the same.

#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Share of the position tolerance that a plan may use, together with half a step of the
/// axes; the rest is for friction, cogging and play, which no plan predicts.
inline constexpr double kPlannedErrorRatio = 0.8;

/// A tolerance of which half a step of the axes (AxisLimits.steps_per_mm) leaves nothing
/// to a plan: kInvalidValue. `machine` is otherwise checked.
void CheckSteps(const MachineSpec& machine, std::vector<Error>& errors);

/// What differs and what to do, in one sentence; empty: they agree within 1 %, or one of
/// them is not known (0). Both um.
std::string ToleranceMismatch(double controller_um, double profile_um);

}  // namespace intaglio
