#pragma once

// How exact the times of a controller's edges are on this computer: simulated outputs,
// each tick armed, and no line.

#include "services/reference_controller/controller.h"
#include "services/reference_controller/edge_record.h"

namespace intaglio::reference_controller {

/// Ends early once `stops` is true. kInvalidValue: the board has no such rate. kRefused:
/// it ended before a pulse.
Result<Jitter> MeasureJitter(ControllerOptions options, double rate_hz, double seconds,
                             const ControllerTime& time,
                             const std::function<bool()>& stops);

}  // namespace intaglio::reference_controller
