#include "services/drivers/laser_controller.h"

#include <array>

#include "engrave/core/try.h"
#include "services/drivers/virtual_laser_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {
namespace {

constexpr std::array kLaserKinds = {
    LaserDriverKind{"virtual-laser", true, &MakeVirtualLaserDriver},
};

}  // namespace

std::span<const LaserDriverKind> LaserDriverKinds() { return kLaserKinds; }

Result<std::unique_ptr<LaserController>> MakeLaserDriver(const MachineSpec& machine) {
  const SerialLine& line = machine.laser_line();
  const auto kind = INTAGLIO_TRY(link::FindDriver(
      LaserDriverKinds(), {"laser_line", line.protocol(), line.device()}));
  return kind->make(machine, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::drivers
