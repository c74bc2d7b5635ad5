#pragma once

// What a service says to the system that started it (systemd, Type=notify): that it is
// ready, that its loop turns, that it ends. Nothing happens without such a system.

#include <string>

namespace intaglio::host {

/// Once the service has begun: who waited for it goes on.
void TellInitReady(const std::string& what);
/// To be said from the service's loop, more often than WatchdogSec.
void TellInitAlive();
void TellInitStopping();

}  // namespace intaglio::host
