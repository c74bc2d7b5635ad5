#pragma once

// Driver of the virtual engraver's laser controller:
// services/platform/link/laser_protocol.h.
//
// A controller with another serial number than the expected one is refused at the
// handshake: its line counts as down, nothing of it is taken, and nothing is sent but,
// once a session, "shutters closed, disarm, lamp off". So it is when the cable was
// swapped while the process runs.

#include "proto/machine.pb.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/shared_line.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

std::unique_ptr<LaserController> MakeVirtualLaserDriver(const MachineSpec& machine,
                                                        link::StreamOpener open,
                                                        link::SteadyClock clock);
/// On a line that carries other frames, too.
std::unique_ptr<LaserController> MakeVirtualLaserDriver(const MachineSpec& machine,
                                                        link::FramePort port,
                                                        link::SteadyClock clock);

}  // namespace intaglio::drivers
