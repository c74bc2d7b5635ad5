#pragma once

// The guarantees of mark_driver.h as checks that run on any rig. They return what is
// violated instead of failing a test, so that a test can see that they do find a fault.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/services/drivers/marks/mark_rig.h"

namespace intaglio::drivers {

/// A fresh rig; of one whose profile names another controller when that is given.
using MarkRigMaker =
    std::function<std::unique_ptr<MarkRig>(const std::string& serial_number)>;

struct MarkCheck {
  std::string name;  ///< with the guarantees' numbers
  std::function<void(const MarkRigMaker& make)> run;
};

/// K9 and K10 have one for each fault and instant of controller_fault.h.
const std::vector<MarkCheck>& MarkChecks();

/// The first violation, in a sentence; empty when the check passes.
std::string ViolationOf(const MarkCheck& check, const MarkRigMaker& make);

}  // namespace intaglio::drivers
