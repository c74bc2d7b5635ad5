#pragma once

// Driver of the virtual engraver's stage controller:
// services/platform/link/motion_protocol.h.
//
// A controller with another serial number than the expected one is refused at the
// handshake: its line counts as down, nothing of it is taken, and nothing is sent but one
// AbortRun a session, which brakes what another host may have left running.

#include "proto/machine.pb.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/shared_line.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine,
                                                     link::StreamOpener open,
                                                     link::SteadyClock clock);
/// On a line that carries other frames, too.
std::unique_ptr<MotionDriver> MakeVirtualStageDriver(const MachineSpec& machine,
                                                     link::FramePort port);

}  // namespace intaglio::drivers
