#pragma once

// The checks of M19: outlines that a guide laser draws. A driver without one passes them
// by saying so.

#include <vector>

#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {

/// Also one for each fault of controller_fault.h, in an outline.
std::vector<MotionCheck> OutlineChecks();

}  // namespace intaglio::drivers
