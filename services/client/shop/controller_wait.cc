#include "services/client/shop/controller_wait.h"

#include "services/client/shop/known_machines.h"
#include "services/platform/host/process/patience.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;

enum class Line { kUnknown, kDown, kUp };

Line LineOf(const std::string& cell, const KnownMachines& known) {
  const auto machines = known.machines();
  const auto machine = machines.find(cell);
  if (machine == machines.end() || !machine->second.has_interlock) return Line::kUnknown;
  return machine->second.laser_line_up ? Line::kUp : Line::kDown;
}

}  // namespace

bool AwaitController(bus::Bus& bus, JobClient& client, const std::string& cell,
                     const std::function<void()>& waits) {
  KnownMachines known(bus);
  host::Patience discovery(bus.discovery_time());
  host::Patience patience(kControllerAnswersWithin);
  for (bool waits_for_it = false;; client.Poll(20ms)) {
    known.Poll();
    const Line line = LineOf(cell, known);
    if (line == Line::kUp) return true;
    if (line == Line::kUnknown && !waits_for_it) {
      if (discovery.IsUp()) return true;
      continue;
    }
    if (!waits_for_it) waits();
    waits_for_it = true;
    if (patience.IsUp()) return false;
  }
}

}  // namespace intaglio::client
