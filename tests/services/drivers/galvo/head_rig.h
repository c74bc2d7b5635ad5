#pragma once

// A virtual scan head at its driver, for the checks of every mark driver.

#include <memory>
#include <string>

#include "tests/services/drivers/marks/mark_rig.h"

namespace intaglio::drivers {

std::unique_ptr<MarkRig> MakeHeadMarkRig(const std::string& name,
                                         const std::string& serial_number);

}  // namespace intaglio::drivers
