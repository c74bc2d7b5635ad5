#pragma once

// What the driver of a scan head needs of a machine profile (MachineSpec.scan_head).

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio::drivers {

/// Each error begins with the field.
std::vector<Error> CheckScanHead(const MachineSpec& machine);

}  // namespace intaglio::drivers
