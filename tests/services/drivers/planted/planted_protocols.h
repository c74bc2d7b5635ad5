#pragma once

// The protocols of the drivers on which planted faults are tried in simulated time.
// linuxcnc_planted_test tries LinuxCNC's in real time.

#include <string>
#include <string_view>
#include <vector>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/motion_drivers.h"

namespace intaglio::drivers {

inline constexpr std::string_view kInRealTime = "linuxcnc";

inline std::vector<std::string> MotionProtocols() {
  std::vector<std::string> all;
  for (const MotionDriverKind& kind : MotionDriverKinds())
    if (kind.protocol != kInRealTime) all.emplace_back(kind.protocol);
  return all;
}

/// Also of motion controllers that switch the laser.
inline std::vector<std::string> LaserProtocols() {
  std::vector<std::string> all;
  for (const LaserDriverKind& kind : LaserDriverKinds()) all.emplace_back(kind.protocol);
  for (const MotionDriverKind& kind : MotionDriverKinds())
    if (kind.switches_laser && kind.protocol != kInRealTime)
      all.emplace_back(kind.protocol);
  return all;
}

}  // namespace intaglio::drivers
