#include "services/drivers/profile_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/mark_drivers.h"
#include "services/drivers/motion_drivers.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {
namespace {

template <typename Kind>
const Kind* KindOf(std::span<const Kind> kinds, const std::string& protocol) {
  const auto found = std::ranges::find_if(
      kinds, [&](const Kind& kind) { return kind.protocol == protocol; });
  return found == kinds.end() ? nullptr : &*found;
}

/// Only that there is such a driver.
template <typename Kind>
void AddUnknown(std::span<const Kind> kinds, const std::string& field,
                const SerialLine& line, std::vector<Error>& errors) {
  if (KindOf(kinds, line.protocol()) != nullptr || line.protocol().empty()) return;
  errors.push_back(
      link::FindDriver(kinds, {field, line.protocol(), line.device()}).error());
}

template <typename Kind>
Result<std::vector<Error>> CompareController(std::span<const Kind> kinds,
                                             const SerialLine& line,
                                             const MachineSpec& machine,
                                             const link::SteadyClock& clock) {
  const auto* kind = KindOf(kinds, line.protocol());
  if (kind == nullptr || kind->compare == nullptr) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("controllers of the protocol {} report no identity",
                            line.protocol()));
  }
  return kind->compare(machine, link::EndpointOpener(line.device(), line.baud()), clock);
}

}  // namespace

std::vector<Error> CheckDrivers(const MachineSpec& machine) {
  std::vector<Error> errors;
  AddUnknown(LaserDriverKinds(), "laser_line", machine.laser_line(), errors);
  AddUnknown(MotionDriverKinds(), "motion_line", machine.motion_line(), errors);
  AddUnknown(MarkDriverKinds(), "mark_line", machine.mark_line(), errors);
  if (const auto* marks = KindOf(MarkDriverKinds(), machine.mark_line().protocol());
      marks != nullptr && marks->check != nullptr) {
    for (Error& error : marks->check(machine)) errors.push_back(std::move(error));
  }
  if (const auto* laser = KindOf(LaserDriverKinds(), machine.laser_line().protocol())) {
    if (const Status served = CheckAccessoryLine(machine, *laser); !served)
      errors.push_back(served.error());
  }
  const auto* kind = KindOf(MotionDriverKinds(), machine.motion_line().protocol());
  if (kind == nullptr) return errors;
  if (machine.laser_line().protocol() == kMotionOutput) {
    if (const Status output = CheckMotionOutput(machine); !output)
      errors.push_back(output.error());
  }
  if (const Status air = CheckAir(machine, *kind); !air) errors.push_back(air.error());
  if (const Status block = CheckBlockStage(machine, *kind); !block)
    errors.push_back(block.error());
  if (kind->check != nullptr) {
    for (Error& error : kind->check(machine)) errors.push_back(std::move(error));
  }
  return errors;
}

Result<std::vector<Error>> CompareMotionController(const MachineSpec& machine,
                                                   const link::SteadyClock& clock) {
  return CompareController(MotionDriverKinds(), machine.motion_line(), machine, clock);
}

Result<std::vector<Error>> CompareMarkController(const MachineSpec& machine,
                                                 const link::SteadyClock& clock) {
  return CompareController(MarkDriverKinds(), machine.mark_line(), machine, clock);
}

}  // namespace intaglio::drivers
