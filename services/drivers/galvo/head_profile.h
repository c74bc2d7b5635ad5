#pragma once

// What the driver of a scan head needs of a machine profile (MachineSpec.scan_head).

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio::drivers {

inline constexpr double kDefaultAheadMs = 40;
/// How long before they are played ticks are sent.
inline double AheadSeconds(const ScanHead& head) {
  return 1e-3 * (head.has_ahead_ms() ? head.ahead_ms() : kDefaultAheadMs);
}

/// Each error begins with the field.
std::vector<Error> CheckScanHead(const MachineSpec& machine);

}  // namespace intaglio::drivers
