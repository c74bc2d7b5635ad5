#pragma once

// A virtual BJJCZ board at the driver of points in glass: as the rig of a motion driver,
// and as that of a laser driver.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/services/drivers/bjjcz/bjjcz_machine.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/motion_rig.h"

namespace intaglio::drivers {

inline constexpr double kBoardFieldMm = 110, kBoardStepsPerMm = 1000;
inline constexpr double kBoardPlacesPerMm = 65536 / kBoardFieldMm;

/// How many points a list has at most.
inline constexpr std::uint32_t kBoardListPoints = 32;

/// The guide laser's output.
inline constexpr std::uint32_t kBoardGuideOutput = 8;

/// A field of 110 mm, of which 100 mm are travelled; points of 0.5 ms.
MachineSpec BjjczPointProfile();

/// The board's driver; its z was homed at the machine.
std::unique_ptr<MotionDriver> MakeBjjczPointDriverAt(BjjczMachine& machine,
                                                     const MachineSpec& profile);

std::unique_ptr<MotionRig> MakeBjjczMotionRig(const std::string& name,
                                              const std::string& serial_number);
/// The same of another profile than BjjczPointProfile.
std::unique_ptr<MotionRig> MakeBjjczMotionRigOf(const MachineSpec& profile);
std::unique_ptr<LaserRig> MakeBjjczLaserRig(const std::string& name,
                                            const std::string& serial_number);

}  // namespace intaglio::drivers
