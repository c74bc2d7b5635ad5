#pragma once

// The tool of a machine that follows contours (proto/machine.proto, CourseTool), with its
// defaults.

#include "proto/machine.pb.h"

namespace intaglio {

/// z of the way between contours, mm above the work zero.
inline double SafeHeightOf(const CourseTool& tool) {
  return tool.has_safe_height_mm() ? tool.safe_height_mm() : 5;
}

/// Until a spindle turns at its speed.
inline double SpinUpOf(const CourseTool& tool) {
  return tool.has_spin_up_s() ? tool.spin_up_s() : 3;
}

/// The output of its laser is on or off: jobs have the power 1.
inline bool SwitchesBeamOnly(const MachineSpec& machine) {
  return machine.mark_line().protocol() == "linuxcnc-course";
}

}  // namespace intaglio
