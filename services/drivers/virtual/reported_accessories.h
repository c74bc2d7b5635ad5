#pragma once

// What a laser controller reports of its outputs and inputs for other uses, by the names
// of the machine profile.

#include <string>

#include "proto/machine.pb.h"
#include "services/drivers/interface/laser_controller.h"

namespace intaglio::drivers {

/// `state` of a controller that has sent none: all 0.
Accessories ReportedAccessories(const MachineSpec& machine,
                                const link::AccessoryState& state);

}  // namespace intaglio::drivers
