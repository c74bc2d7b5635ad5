#pragma once

// The checks of outlines in K12, of machines that make marks. A driver without a guide
// laser passes them by saying so.

#include <vector>

#include "tests/services/drivers/marks/mark_conformance.h"

namespace intaglio::drivers {

/// Also one for each fault of controller_fault.h, in an outline.
std::vector<MarkCheck> MarkOutlineChecks();

}  // namespace intaglio::drivers
