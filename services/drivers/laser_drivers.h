#pragma once

// The families of laser controllers, and the driver that a profile names.

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// One row of the table of controller families.
struct LaserDriverKind {
  std::string_view protocol;  ///< laser_line.protocol of the profile
  bool needs_device;          ///< it opens laser_line.device through `open`
  /// `open` is unused by a driver that needs no device.
  std::unique_ptr<LaserController> (*make)(const MachineSpec& machine,
                                           link::StreamOpener open,
                                           link::SteadyClock clock);
  bool serves_accessories = false;  ///< outputs and inputs of the profile
};

/// kUnsupported: the profile names outputs or inputs, and this family serves none.
Status CheckAccessoryLine(const MachineSpec& machine, const LaserDriverKind& kind);

/// All there are.
std::span<const LaserDriverKind> LaserDriverKinds();

/// laser_line.device; of a motion output without one a socket of the cell's name in the
/// folder that the system gives to services or users: the first there is of
/// $RUNTIME_DIRECTORY, $XDG_RUNTIME_DIR/intaglio, /tmp/intaglio-UID.
std::string LaserDeviceOf(const MachineSpec& machine);

/// The driver that the machine's laser_line names, on its device and the clock of this
/// computer. kUnsupported lists what there is; kMissing, kInvalidValue: its device.
Result<std::unique_ptr<LaserController>> MakeLaserDriver(const MachineSpec& machine);

}  // namespace intaglio::drivers
