#pragma once

// Step motors are stepped by a controller that has a highest rate. The machine profile
// has the speeds that the plan uses. They are compared when the controller reports its
// own, before anything is planned or moved.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Each axis of the profile that is faster than `controller_max`: "field: value, the
/// largest that works; remedy". mm/s, or rad/s of an axis that turns, in the order of
/// the axes. Its travel and acceleration have no part in it.
std::vector<Error> CompareStageSpeed(const MachineSpec& machine,
                                     const Vec3& controller_max);

}  // namespace intaglio
