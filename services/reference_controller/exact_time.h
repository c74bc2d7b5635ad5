#pragma once

// The clock of this computer, and a wait on it that is as exact as the system allows.

#include "services/reference_controller/controller.h"

namespace intaglio::reference_controller {

/// Sleeps up to 100 us before the time, and then reads the clock until it has come.
ControllerTime ExactTime();

}  // namespace intaglio::reference_controller
