#pragma once

// What is allowed in the profile of a scan head and makes poor work: mirrors whose jumps
// are burnt, and an axis of a BJJCZ board that nobody has measured.

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Each begins with the field's path. Of a profile that passes CheckMachine; of one
/// without a scan head there are none.
std::vector<Error> HeadWarningsOf(const MachineSpec& machine);

}  // namespace intaglio
