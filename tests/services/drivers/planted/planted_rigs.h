#pragma once

// Rigs of a protocol whose driver has a planted fault. `plant` takes a driver and gives
// the one with the fault.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::drivers {

/// Whether what this protocol's driver drives can be moved by hand.
inline bool Jogs(const std::string& protocol) {
  const auto rig = MakeMotionRig(protocol);
  const auto jogged = rig->driver->Jog(Vec3::Zero(), 1);
  return jogged || jogged.error().code != ErrorCode::kUnsupported;
}

/// Whether this protocol's driver draws outlines with a guide laser.
inline bool DrawsOutlines(const std::string& protocol) {
  const auto rig = MakeMotionRig(protocol);
  const auto drawn = rig->driver->DrawOutline(std::vector{Vec2(0, 0)}, 1);
  return drawn || drawn.error().code != ErrorCode::kUnsupported;
}

/// Whether this protocol's driver moves a stage that carries the block.
inline bool CarriesABlock(const std::string& protocol) {
  return MakeMotionRig(protocol)->driver->RequireBlockAt(Vec2(1, 0)).has_value();
}

inline MotionRigMaker PlantedMotionRigs(
    const std::string& protocol,
    std::unique_ptr<MotionDriver> (*plant)(std::unique_ptr<MotionDriver> good)) {
  return [protocol, plant](const std::string& serial_number) {
    auto rig = MakeMotionRig(protocol, serial_number);
    rig->driver = plant(std::move(rig->driver));
    return rig;
  };
}

inline LaserRigMaker PlantedLaserRigs(
    const std::string& protocol,
    std::unique_ptr<LaserController> (*plant)(std::unique_ptr<LaserController> good)) {
  return [protocol, plant](const std::string& serial_number) {
    auto rig = MakeLaserRig(protocol, serial_number);
    rig->driver = plant(std::move(rig->driver));
    return rig;
  };
}

}  // namespace intaglio::drivers
