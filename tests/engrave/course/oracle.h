#pragma once

// An independent model of the machine and of the error, for tests: the loops of an axis
// step by step (Runge-Kutta of fourth order) where engrave/course has exact solutions and
// poles, and distances by trying all.

#include <array>
#include <vector>

#include "engrave/course/axis_dynamics.h"
#include "engrave/course/path.h"

namespace intaglio::course {

/// Position, velocity and current loop around a motor whose bandwidths are as 1:3:12, or
/// a motor of first order, with a mass on a spring and a damper behind it.
struct OracleAxis {
  bool cascade = false;
  double bandwidth_rad_s = 0, natural_rad_s = 0, damping_ratio = 0;
};

std::array<OracleAxis, 2> OracleOf(const AxisPair& axes);

/// The actual positions while the command goes straight from setpoint to setpoint, in
/// `fine` steps a setpoint: fine (n - 1) + 1 points. The axes begin settled on the line
/// of the first two setpoints.
std::vector<Vec2> OracleFollow(const std::array<OracleAxis, 2>& axes,
                               const std::vector<Vec2>& setpoints_mm, double period_s,
                               int fine);

/// From a leg through the origin: that which comes along `direction` (side -1) or leaves
/// along it (side 1).
double ToLeg(const Vec2& p_mm, const Vec2& direction, double side);

struct OracleError {
  double one_sided_mm = 0;   ///< from the course to the path
  double node_miss_mm = 0;   ///< from the nodes to the course
  double other_side_mm = 0;  ///< from points of the path, a tenth of a mm apart
};

/// Nearest places are searched within 12 mm of path around the commanded place.
OracleError OracleMeasure(const Path& path, const std::vector<Vec2>& actual_mm,
                          const std::vector<double>& commanded_s_mm);

}  // namespace intaglio::course
