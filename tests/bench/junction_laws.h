#pragma once

// The corner speeds of two open controllers, from their published descriptions, to be
// compared with engrave/course. Neither has a model of the drive: a parameter is chosen
// by hand.

#include <vector>

#include "engrave/course/path.h"

namespace intaglio::course {

/// grblHAL, as Grbl: S. Jeon, "Improving Grbl: Cornering Algorithm", 2011. A circle that
/// touches both legs and is `deviation_mm` from the corner: R = d sin(h) / (1 - sin(h)),
/// h half the angle between the legs; v^2 = a R. For each inner node, mm/s.
std::vector<double> GrblNodeSpeeds(const Path& path, double deviation_mm,
                                   double acceleration_mm_s2);

/// Klipper: its documentation "Kinematics", chapter look-ahead. The deviation follows
/// from the speed through a corner of 90 degrees, d = scv^2 (sqrt 2 - 1) / a; besides,
/// the circle may not touch a leg beyond its middle: v^2 <= a L / 2 tan(h). Its reduction
/// of peak speeds (minimum_cruise_ratio) is 0, which is the fastest.
std::vector<double> KlipperNodeSpeeds(const Path& path, double square_corner_mm_s,
                                      double acceleration_mm_s2);

}  // namespace intaglio::course
