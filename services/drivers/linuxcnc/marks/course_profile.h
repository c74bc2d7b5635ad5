#pragma once

// What the driver "linuxcnc-course" needs of a profile, and what it makes of marks: a
// laser whose output is on or off, along contours within the travel of x and y.

#include <vector>

#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/machine.pb.h"
#include "services/drivers/interface/mark_driver.h"

namespace intaglio::drivers {

/// Each error begins with the field: course_tool.kind, x and y with travel, speed
/// and acceleration, position_tolerance_um, a drive that courses are
/// planned for.
std::vector<Error> CheckLinuxcncCourseProfile(const MachineSpec& machine);

/// kUnsupported: a depth, a power that is not 1, a frequency, a speed above those of the
/// axes.
Status CheckBeamPen(const mark::Pen& pen, const MachineSpec& machine);

/// kUnsupported: a row of dots, a place without a way, a contour of more than an hour,
/// for it is planned as a whole. kInvalidValue: outside the travel.
Status CheckBeamMark(const NumberedMark& mark, const mark::Pen& pen,
                     const MachineSpec& machine);

}  // namespace intaglio::drivers
