#pragma once

// Mark drivers with one planted fault each: a wrapper around a good driver of any family
// that misbehaves in one way. A conformance suite that passes one of them checks less
// than the guarantees state.

#include <memory>
#include <span>

#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

/// The drivers and rigs that can have a fault.
enum class FaultOf { kAll, kToolsWithAxes, kKnownPowerUps, kGuideLasers };

struct MarkFault {
  const char* name;
  const char* check;  ///< beginning of the names of those of MarkChecks that find it
  std::unique_ptr<MarkDriver> (*plant)(std::unique_ptr<MarkDriver> good);
  FaultOf of = FaultOf::kAll;
};
std::span<const MarkFault> MarkFaults();

}  // namespace intaglio::drivers
