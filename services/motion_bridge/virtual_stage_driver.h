#pragma once

// Driver of the virtual engraver's stage controller: services/link/motion_protocol.h.

#include <memory>

#include "services/link/line_session.h"
#include "services/motion_bridge/motion_driver.h"

namespace intaglio::motion_bridge {

/// Over motion_line.device of the machine.
std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine);

/// Over any line and clock; what tests use.
std::unique_ptr<MotionDriver> MakeVirtualStageDriver(link::StreamOpener open,
                                                     link::SteadyClock clock);

}  // namespace intaglio::motion_bridge
