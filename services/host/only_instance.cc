#include "services/host/only_instance.h"

namespace intaglio::host {

int EndTakenOver(ServiceHost& host, const std::string& name) {
  const std::string text =
      "another " + name + " has taken this machine over; this process ends";
  host.SetHealth(intaglio_HEALTH_FAULT, {}, text);
  host.RaiseAlarm(intaglio_ALARM_FAULT, "taken_over", text);
  return kExitTakenOver;
}

}  // namespace intaglio::host
