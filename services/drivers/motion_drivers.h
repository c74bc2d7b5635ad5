#pragma once

// The families of motion controllers, and the driver that a profile names.

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// One row of the table of controller families.
struct MotionDriverKind {
  std::string_view protocol;  ///< motion_line.protocol of the profile
  bool needs_device;          ///< it opens motion_line.device through `open`
  /// `open` is unused by a driver that needs no device.
  std::unique_ptr<MotionDriver> (*make)(const MachineSpec& machine,
                                        link::StreamOpener open, link::SteadyClock clock);
  bool switches_laser = false;  ///< what it makes has a laser()
  /// What it needs of a profile and does not find, each error beginning with the field;
  /// null: nothing beyond what every machine needs.
  std::vector<Error> (*check)(const MachineSpec& machine) = nullptr;
  /// What a controller on the line reports and the profile has otherwise
  /// (services/drivers/profile_check.h); null: the family reports nothing.
  Result<std::vector<Error>> (*compare)(const MachineSpec& machine,
                                        const link::StreamOpener& open,
                                        const link::SteadyClock& clock) = nullptr;
  /// It refuses a controller that does not watch compressed air where the profile has it.
  bool watches_air = false;
  /// It moves a stage that carries the block (MotionDriver, M20), and refuses a
  /// controller without one where the profile has it.
  bool moves_block = false;
};

/// All there are.
std::span<const MotionDriverKind> MotionDriverKinds();

/// kUnsupported unless the machine's motion controller switches a laser; the message
/// lists those that do.
Status CheckMotionOutput(const MachineSpec& machine);

/// kUnsupported when the machine has compressed air and the driver does not watch it.
Status CheckAir(const MachineSpec& machine, const MotionDriverKind& kind);

/// kUnsupported when the machine has a stage that carries the block under its head and
/// the driver cannot move it; the message lists those that can.
Status CheckBlockStage(const MachineSpec& machine, const MotionDriverKind& kind);

/// The driver that the machine's motion_line names, on its device and the clock of this
/// computer. kUnsupported lists what there is; kMissing, kInvalidValue: its device, or
/// what this family needs of a profile, by name.
Result<std::unique_ptr<MotionDriver>> MakeMotionDriver(const MachineSpec& machine);

}  // namespace intaglio::drivers
