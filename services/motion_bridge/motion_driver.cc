#include "services/motion_bridge/motion_driver.h"

#include <array>

#include "engrave/core/try.h"
#include "services/motion_bridge/virtual_stage_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::motion_bridge {
namespace {

constexpr std::array kKinds = {
    MotionDriverKind{"virtual-stage", true, &MakeVirtualStageDriver},
};

}  // namespace

std::span<const MotionDriverKind> MotionDriverKinds() { return kKinds; }

Result<std::unique_ptr<MotionDriver>> MakeDriver(const MachineSpec& machine) {
  const SerialLine& line = machine.motion_line();
  const auto kind = INTAGLIO_TRY(link::FindDriver(
      MotionDriverKinds(), {"motion_line", line.protocol(), line.device()}));
  return kind->make(machine, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::motion_bridge
