#pragma once

// A servo axis with a controller that is fast enough to be continuous, under a constant
// load from the start on: tau x'' + x' = K (r - x) + D (r' - x') + phi r' - tau a_load.
// Exact over commands that are cubic in time.

#include <vector>

#include "engrave/drive/linear_drive.h"
#include "engrave/drive/loop_kinds.h"

namespace intaglio::drive {

struct CommandPiece {
  Cubic command;
  double duration_s = 0;  ///< > 0
};

/// From rest at 0 to rest at `length` > 0 with at most `speed` and `acceleration` > 0, in
/// one unit of length; two or three pieces, then rest for `rest_s` if that is above 0.
/// Trochimczuk 2008, (12)-(15).
std::vector<CommandPiece> Trapezoid(double length, double speed, double acceleration,
                                    double rest_s);

class ContinuousAxis {
 public:
  /// At rest at `start`; the load, in length/s^2 towards -, begins then. All of `servo`
  /// as in loop_kinds.h.
  ContinuousAxis(const ServoLoop& servo, double load_acceleration, double start);

  void Follow(const Cubic& command, double duration_s);
  double position() const { return of_command_.position_u + of_load_.position_u; }
  double speed() const { return of_command_.velocity_u_s + of_load_.velocity_u_s; }
  /// With a command of this place and speed, from now on.
  double Acceleration(double commanded, double commanded_speed) const;

 private:
  ServoLoop servo_;
  double load_acceleration_;
  LinearDrive drive_;
  LinearDrive load_drive_;  ///< the same poles, no zeros
  AxisState of_command_, of_load_;
};

}  // namespace intaglio::drive
