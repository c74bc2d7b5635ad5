#pragma once

// The families of controllers that mark, and the driver that a profile names.

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/interface/mark_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// One row of the table of controller families.
struct MarkDriverKind {
  std::string_view protocol;  ///< mark_line.protocol of the profile
  bool needs_device;          ///< it opens mark_line.device through `open`
  std::unique_ptr<MarkDriver> (*make)(const MachineSpec& machine, link::StreamOpener open,
                                      link::SteadyClock clock);
  /// What it needs of a profile and does not find, each error beginning with the field.
  std::vector<Error> (*check)(const MachineSpec& machine);
  /// What a controller on the line reports and the profile has otherwise
  /// (services/drivers/profile_check.h); null: the family reports nothing.
  Result<std::vector<Error>> (*compare)(const MachineSpec& machine,
                                        const link::StreamOpener& open,
                                        const link::SteadyClock& clock) = nullptr;
};

/// All there are.
std::span<const MarkDriverKind> MarkDriverKinds();

/// The driver that the machine's mark_line names. kUnsupported lists what there is;
/// kMissing, kInvalidValue: its device, or what this family needs of a profile, by name.
Result<std::unique_ptr<MarkDriver>> MakeMarkDriver(const MachineSpec& machine);

}  // namespace intaglio::drivers
