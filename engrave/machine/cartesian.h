#pragma once

// Three linear axes, each moving the head or the table, counting up or down
// (Trochimczuk 2008 ch. 1, fig. 1, and fig. 45). Where the table moves, the focus goes
// the other way through the block: a head's coordinates would engrave the mirror image.
// Scales and squareness are what a measurement of the machine corrects
// (engrave/calibrate).

#include <memory>

#include "engrave/machine/kinematics.h"

namespace intaglio::machine {

std::shared_ptr<const Kinematics> MakeCartesian(const CartesianOptions& options);

}  // namespace intaglio::machine
