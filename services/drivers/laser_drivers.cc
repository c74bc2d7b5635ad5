#include "services/drivers/laser_drivers.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "engrave/core/try.h"
#include "services/drivers/motion_drivers.h"
#include "services/drivers/virtual/virtual_laser_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {
namespace {

constexpr std::array kLaserKinds = {
    LaserDriverKind{"virtual-laser", true, &MakeVirtualLaserDriver, true},
    // The same frames, from the motion bridge.
    LaserDriverKind{kMotionOutput, true, &MakeVirtualLaserDriver},
};

std::string RuntimeFolder() {
  if (const char* service = std::getenv("RUNTIME_DIRECTORY"); service && *service) {
    const std::string_view all = service;
    return std::string(all.substr(0, all.find(':')));
  }
  if (const char* user = std::getenv("XDG_RUNTIME_DIR"); user && *user)
    return std::string(user) + "/intaglio";
  return fmt::format("/tmp/intaglio-{}", geteuid());
}

}  // namespace

std::span<const LaserDriverKind> LaserDriverKinds() { return kLaserKinds; }

Status CheckAccessoryLine(const MachineSpec& machine, const LaserDriverKind& kind) {
  const bool names_any = machine.outputs_size() + machine.inputs_size() > 0;
  if (!names_any || kind.serves_accessories) return {};
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("{}: a laser_line of the protocol '{}' serves no outputs and no "
                  "inputs for other uses; connect them to the controller's own "
                  "chain, and remove the field",
                  machine.outputs_size() > 0 ? "outputs" : "inputs", kind.protocol),
      std::string(kind.protocol));
}

std::string LaserDeviceOf(const MachineSpec& machine) {
  const SerialLine& line = machine.laser_line();
  if (!line.device().empty() || line.protocol() != kMotionOutput) return line.device();
  return fmt::format("unix:{}/{}.laser", RuntimeFolder(), machine.name());
}

Result<std::unique_ptr<LaserController>> MakeLaserDriver(const MachineSpec& machine) {
  MachineSpec whole = machine;
  whole.mutable_laser_line()->set_device(LaserDeviceOf(machine));
  const SerialLine& line = whole.laser_line();
  const auto kind = INTAGLIO_TRY(link::FindDriver(
      LaserDriverKinds(), {"laser_line", line.protocol(), line.device()}));
  if (line.protocol() == kMotionOutput) INTAGLIO_TRY(CheckMotionOutput(machine));
  INTAGLIO_TRY(CheckAccessoryLine(machine, *kind));
  return kind->make(whole, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::drivers
