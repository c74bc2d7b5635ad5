#pragma once

// The checks of M20: the stage that carries the block under a scan head. A driver without
// one passes them by refusing each place but 0.

#include <vector>

#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {

std::vector<MotionCheck> BlockChecks();

}  // namespace intaglio::drivers
