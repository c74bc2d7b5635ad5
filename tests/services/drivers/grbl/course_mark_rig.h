#pragma once

// A virtual grbl at the driver of marks, for the checks of every mark driver.

#include <memory>
#include <string>

#include "tests/services/drivers/marks/mark_rig.h"

namespace intaglio::drivers {

/// "grbl_laser", "grbl_mill", and "grbl_mill_that_homes", which has homed.
std::unique_ptr<MarkRig> MakeCourseMarkRig(const std::string& name,
                                           const std::string& serial_number);

}  // namespace intaglio::drivers
