#include "services/platform/host/process/init_system.h"

#include <systemd/sd-daemon.h>

namespace intaglio::host {

void NotifyInitReady(const std::string& what) {
  sd_notify(0, ("READY=1\nSTATUS=" + what).c_str());
}

void NotifyInitAlive() { sd_notify(0, "WATCHDOG=1"); }

void NotifyInitStopping() { sd_notify(0, "STOPPING=1"); }

}  // namespace intaglio::host
