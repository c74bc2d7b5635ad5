#pragma once

// Reports to the system that started a service (systemd, Type=notify): that it is ready,
// that its loop runs, that it ends. Does nothing without such a system.

#include <string>

namespace intaglio::host {

/// Once the service has begun: units that wait for it are started.
void NotifyInitReady(const std::string& what);
/// To be called from the service's loop, more often than WatchdogSec.
void NotifyInitAlive();
void NotifyInitStopping();

}  // namespace intaglio::host
