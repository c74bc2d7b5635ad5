#pragma once

// Arm and rotary table (Trochimczuk 2008 ch. 8.4, eq. 130-135; the sixth row of its table
// 6 corrected). With a signed angle beta one configuration reaches both halves of the
// piece: neither scenario of the source (the arm sweeps and the table indexes; the table
// turns and the arm indexes) ever changes it.

#include <memory>

#include "engrave/machine/kinematics.h"

namespace intaglio::machine {

std::shared_ptr<const Kinematics> MakePolar(const PolarOptions& options);

}  // namespace intaglio::machine
