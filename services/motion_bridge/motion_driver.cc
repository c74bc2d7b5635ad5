#include "services/motion_bridge/motion_driver.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "services/motion_bridge/virtual_stage_driver.h"

namespace intaglio::motion_bridge {
namespace {

struct Family {
  std::string_view protocol;
  std::unique_ptr<MotionDriver> (*make)(const MachineSpec&);
};

constexpr std::array kFamilies = {
    Family{"virtual-stage", &MakeVirtualStageDriver},
};

}  // namespace

Result<std::unique_ptr<MotionDriver>> MakeDriver(const MachineSpec& machine) {
  std::string known;
  for (const Family& family : kFamilies) {
    if (family.protocol == machine.motion_line().protocol()) return family.make(machine);
    known += (known.empty() ? "" : ", ") + std::string(family.protocol);
  }
  return Fail(ErrorCode::kUnsupported,
              fmt::format("motion_line.protocol: no driver for '{}'; there are: {}",
                          machine.motion_line().protocol(), known),
              machine.motion_line().protocol());
}

}  // namespace intaglio::motion_bridge
