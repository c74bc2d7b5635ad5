#pragma once

// Driver of a scan head's controller (services/platform/link/scan_head_protocol.h) for
// marks: services/drivers/mark_driver.h.
//
// A mark waits here until its kBegun was taken by TakeEvents; then its ticks are sent, at
// most scan_head.ahead_ms before they are played. A mark whose kBegun was taken can still
// end as kNotBegun: the controller dropped it before its beginning, and says so.
// On a web a mark is made when its places are in the field; when it has left the field
// before, the run stops with a fault that names the mark.

#include "services/drivers/mark_driver.h"

namespace intaglio::drivers {

std::unique_ptr<MarkDriver> MakeGalvoDriver(const MachineSpec& machine,
                                            link::StreamOpener open,
                                            link::SteadyClock clock);

}  // namespace intaglio::drivers
