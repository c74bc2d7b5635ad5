#pragma once

// How long the arm over a rotary table has to be (Trochimczuk 2008 ch. 8.1, figs. 59 and
// 60): the shortest arm is the lightest and the stiffest.

#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/machine/kinematics.h"

namespace intaglio::machine {

struct ArmLengths {
  double min_mm = 0, max_mm = 0;
};

/// The arms with which every place of a box is reached, mm: with each length between both
/// the axes are within `travel` (arm and table in rad), with a shorter one they are not,
/// nor with one a little longer. Where travels below a turn leave several such ranges, it
/// is that of the shortest arms. nullopt: no arm reaches all of the box.
/// `options.arm_length_mm` and z are not regarded. `places_mm`: machine frame, not empty.
/// The table's angles are those of AxesOver.
std::optional<ArmLengths> ArmLengthsOver(const PolarOptions& options,
                                         const Box3& places_mm, const Box3& travel);

}  // namespace intaglio::machine
