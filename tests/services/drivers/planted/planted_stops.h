#pragma once

// Drivers with one fault each in what they make of a stop at their controller (M17, L14):
// they go on by themselves, hide it, or take a lost line for one. Each has to be found in
// every row of the suites that it concerns.

#include <memory>
#include <span>

#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"

namespace intaglio::drivers {

enum class StopRows {
  kAll,
  kStops,  ///< all but the lost line
  kLine,   ///< the lost line alone
};

struct MotionStopFault {
  const char* name;
  StopRows rows;
  std::unique_ptr<MotionDriver> (*plant)(std::unique_ptr<MotionDriver> good);
  bool in_a_jog = false;  ///< the rows of that instant have to find it
};
std::span<const MotionStopFault> MotionStopFaults();
/// The same wrapper without a fault: no row may find it.
std::unique_ptr<MotionDriver> PlantNothing(std::unique_ptr<MotionDriver> good);

struct LaserStopFault {
  const char* name;
  StopRows rows;
  std::unique_ptr<LaserController> (*plant)(std::unique_ptr<LaserController> good);
};
std::span<const LaserStopFault> LaserStopFaults();
std::unique_ptr<LaserController> PlantNothing(std::unique_ptr<LaserController> good);

}  // namespace intaglio::drivers
