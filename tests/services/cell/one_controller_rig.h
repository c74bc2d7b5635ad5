#pragma once

// The rigs of the one controller, for both conformance suites.

#include "services/virtual_engraver/laser.h"
#include "services/virtual_engraver/stage.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/motion_rig.h"

namespace intaglio::cell {

inline constexpr char kOneSerialNumber[] = "both-1";

virtual_engraver::StageOptions StageOfOne();
virtual_engraver::LaserOptions LaserOfOne();

/// Its profile names `serial_number`; empty: the one of the controller.
std::unique_ptr<drivers::MotionRig> MakeOneControllerMotionRig(
    const std::string& serial_number = "");
std::unique_ptr<drivers::LaserRig> MakeOneControllerLaserRig(
    const std::string& serial_number = "");

}  // namespace intaglio::cell
