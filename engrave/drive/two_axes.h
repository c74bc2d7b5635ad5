#pragma once

// A course of two servo axes, each driven by its controller, and how far the tool is from
// the path: the regimes of a cutting machine (Tirnovean 2016, ch. 4.6 and 4.7). Frame: of
// the machine, x and y, in m.

#include <array>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/drive/circle.h"
#include "engrave/drive/continuous_axis.h"
#include "engrave/drive/sampled_axis.h"

namespace intaglio::drive {

/// x and y, with the period of one controller.
using TwoAxes = std::array<SampledAxis, 2>;

struct CircleCourse {
  double radius_m = 0, speed_m_s = 0;  ///< > 0
  int turns = 2;                       ///< >= 1
  RotationRule rule = RotationRule::kExact;
};

/// Along +x, then turned by `turn_rad` to the left, as long each.
struct CornerCourse {
  double length_m = 0, speed_m_s = 0, acceleration_m_s2 = 0;  ///< > 0
  double turn_rad = 0;                                        ///< 0..pi
  bool stops = false;   ///< at the corner; else it is passed at full speed
  double rest_s = 0.1;  ///< at the end
};

struct TwoAxisRun {
  std::vector<Vec2> setpoints_m;
  std::array<std::vector<AxisSample>, 2> axes;  ///< of each setpoint
  /// Largest distances from the path: of a circle outside and inside of it, of a corner
  /// on its outer and its inner side; without chords.
  double outside_m = 0, inside_m = 0;
  /// The same without the first turn of a circle; of a corner 0.
  double settled_outside_m = 0, settled_inside_m = 0;
};

/// From (radius, 0) counterclockwise, y at full speed from the first setpoint on. Errors
/// as of Simulate. Throws PreconditionError as CircularInterpolator, and when the periods
/// differ.
Result<TwoAxisRun> SimulateCircle(const TwoAxes& axes, const CircleCourse& course);
Result<TwoAxisRun> SimulateCorner(const TwoAxes& axes, const CornerCourse& course);

/// The places of a command at each period, the first at its begin, from 0.
std::vector<double> SampleCommand(std::span<const CommandPiece> pieces, double period_s);

}  // namespace intaglio::drive
