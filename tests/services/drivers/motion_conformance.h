#pragma once

// The guarantees of motion_driver.h as checks that run on any rig. They return what is
// violated instead of failing a test, so that a test can see that they do find a fault.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/services/drivers/motion_rig.h"

namespace intaglio::drivers {

/// A fresh rig; of one whose profile names another controller when that is given.
using MotionRigMaker =
    std::function<std::unique_ptr<MotionRig>(const std::string& serial_number)>;

struct MotionCheck {
  std::string name;  ///< with the guarantees' numbers
  std::function<void(const MotionRigMaker& make)> run;
};

/// M17 has one for each fault and instant of controller_fault.h, also in a jog.
std::span<const MotionCheck> MotionChecks();
/// Those of M17 alone.
std::vector<MotionCheck> MotionFaultChecks();

/// The first violation, in a sentence; empty when the check passes.
std::string ViolationOf(const MotionCheck& check, const MotionRigMaker& make);

}  // namespace intaglio::drivers
