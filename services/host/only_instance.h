#pragma once

// A machine has one synchronizer and one motion bridge: what a process does that is one
// too many.

#include <string>

#include "services/host/service_host.h"

namespace intaglio::host {

/// Exit code of a service whose machine another process took over.
inline constexpr int kExitTakenOver = 4;

/// The last word of a service whose machine a newer host has taken: a fault on the bus
/// and in the log. `name` is what it is, "synchronizer". Returns kExitTakenOver.
int EndTakenOver(ServiceHost& host, const std::string& name);

}  // namespace intaglio::host
