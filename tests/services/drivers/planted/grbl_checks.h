#pragma once

// What holds of the grbl family where it cannot keep a guarantee of every laser driver
// (LaserRig::stated_violation of its rig). As checks that return what is violated, so
// that a test can see that they find a fault.

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::drivers {

/// What the driver of the rig is exchanged for; empty: nothing.
using LaserPlant =
    std::function<std::unique_ptr<LaserController>(std::unique_ptr<LaserController>)>;

struct GrblCheck {
  const char* name;
  void (*run)(const LaserPlant& plant);
};
std::span<const GrblCheck> GrblChecks();

/// The first violation, in a sentence; empty when the check passes.
std::string ViolationOf(const GrblCheck& check, const LaserPlant& plant = {});

}  // namespace intaglio::drivers
