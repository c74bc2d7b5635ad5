#pragma once

// The guarantees of laser_controller.h as checks that run on any rig. They return what is
// violated instead of failing a test, so that a test can see that they do find a fault.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/services/drivers/laser_rig.h"

namespace intaglio::drivers {

/// A fresh rig; of one whose profile names another controller when that is given.
using LaserRigMaker =
    std::function<std::unique_ptr<LaserRig>(const std::string& serial_number)>;

struct LaserCheck {
  std::string name;  ///< with the guarantees' numbers
  std::function<void(const LaserRigMaker& make)> run;
};

/// L14 has one for each fault and instant of controller_fault.h.
std::span<const LaserCheck> LaserChecks();
/// Those of L14 alone.
std::vector<LaserCheck> LaserFaultChecks();

/// The first violation, in a sentence; empty when the check passes.
std::string ViolationOf(const LaserCheck& check, const LaserRigMaker& make);

}  // namespace intaglio::drivers
