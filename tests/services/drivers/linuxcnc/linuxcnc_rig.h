#pragma once

// The LinuxCNC driver with LinuxCNC itself, in real time: a step is a millisecond or
// more.

#include <memory>
#include <string>

#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/services/drivers/linuxcnc/hal_tap.h"
#include "tests/services/drivers/motion_rig.h"

namespace intaglio::linuxcnc {

/// A rig of this machine, in a folder of the test's own; null when HAL cannot run here.
std::unique_ptr<drivers::MotionRig> MakeMotionRig(const std::string& serial_number = "");
std::unique_ptr<drivers::LaserRig> MakeLaserRig(const std::string& serial_number = "");

}  // namespace intaglio::linuxcnc
