#pragma once

// Driver of the virtual engraver's stage controller:
// services/platform/link/motion_protocol.h.
//
// A controller with another serial number than the expected one is refused at the
// handshake: its line counts as down, nothing of it is taken, and nothing is sent but one
// AbortRun a session, which brakes what another host may have left running.

#include <memory>

#include "services/motion_bridge/motion_driver.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/line_session.h"

namespace intaglio::motion_bridge {

/// Over motion_line.device of the machine.
std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine);

/// Over any line and clock; what tests use. `needs_compare`: a controller without a
/// compare output is refused, too.
std::unique_ptr<MotionDriver> MakeVirtualStageDriver(link::StreamOpener open,
                                                     link::SteadyClock clock,
                                                     link::ExpectedDevice expected = {},
                                                     bool needs_compare = false);

}  // namespace intaglio::motion_bridge
