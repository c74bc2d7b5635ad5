#pragma once

// Driver of the virtual engraver with one line (--laser-line and --motion-line are the
// same): a controller that moves the stage and switches the laser. It is the drivers of
// both controllers on the two ports of that line. The serial numbers of both lines of the
// profile are compared.

#include "proto/machine.pb.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// The object is a LaserController, too.
std::unique_ptr<MotionDriver> MakeVirtualCellDriver(const MachineSpec& machine,
                                                    link::StreamOpener open,
                                                    link::SteadyClock clock);

}  // namespace intaglio::drivers
