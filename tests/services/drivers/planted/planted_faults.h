#pragma once

// Drivers with one planted fault each: a wrapper around a good driver of any family that
// misbehaves in one way. A conformance suite that passes one of them checks less than the
// guarantees state.

#include <memory>
#include <span>

#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"

namespace intaglio::drivers {

struct MotionFault {
  const char* name;
  const char* check;  ///< of MotionChecks, that finds it on every driver
  std::unique_ptr<MotionDriver> (*plant)(std::unique_ptr<MotionDriver> good);
  bool by_hand = false;  ///< only of drivers that jog
  bool draws = false;    ///< only of drivers that draw outlines
  bool carries = false;  ///< only of drivers that move a stage that carries the block
};
std::span<const MotionFault> MotionFaults();

struct LaserFault {
  const char* name;
  const char* check;  ///< of LaserChecks, that finds it where the guarantee is kept
  std::unique_ptr<LaserController> (*plant)(std::unique_ptr<LaserController> good);
};
std::span<const LaserFault> LaserFaults();

}  // namespace intaglio::drivers
