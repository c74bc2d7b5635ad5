#pragma once

// Mark drivers with one planted fault each: a wrapper around a good driver of any family
// that misbehaves in one way. A conformance suite that passes one of them checks less
// than the guarantees state.

#include <memory>
#include <span>

#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

struct MarkFault {
  const char* name;
  const char* check;  ///< beginning of the names of those of MarkChecks that find it
  std::unique_ptr<MarkDriver> (*plant)(std::unique_ptr<MarkDriver> good);
  bool of_tools_with_axes = false;  ///< only of drivers with motion by hand
  bool of_known_power_ups = false;  ///< of rigs that tell_power_ups
};
std::span<const MarkFault> MarkFaults();

}  // namespace intaglio::drivers
