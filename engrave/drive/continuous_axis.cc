#include "engrave/drive/continuous_axis.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// The equation is linear: the answer to the load is that to a command of -tau a / K, for
// which the derivative and the feed-forward of a command do not count.

namespace intaglio::drive {

std::vector<CommandPiece> Trapezoid(double length, double speed, double acceleration,
                                    double rest_s) {
  Require(length > 0 && speed > 0 && acceleration > 0,
          "a move of {} with speed {} and acceleration {}", length, speed, acceleration);
  const double ramp_s = std::min(speed / acceleration, std::sqrt(length / acceleration));
  const double reached = ramp_s * acceleration;
  const double ramp = 0.5 * reached * ramp_s;
  const double at_speed_s = (length - 2 * ramp) / reached;
  std::vector<CommandPiece> pieces = {{{0, 0, acceleration, 0}, ramp_s}};
  // Rounding leaves nothing of a piece at speed that is not there.
  if (at_speed_s > 1e-9 * ramp_s) pieces.push_back({{ramp, reached, 0, 0}, at_speed_s});
  pieces.push_back({{length - ramp, reached, -acceleration, 0}, ramp_s});
  if (rest_s > 0) pieces.push_back({{length, 0, 0, 0}, rest_s});
  return pieces;
}

ContinuousAxis::ContinuousAxis(const ServoLoop& servo, double load_acceleration,
                               double start)
    : servo_(servo),
      load_acceleration_(load_acceleration),
      drive_("servo", TransferOf(servo)),
      load_drive_("load", {{1}, TransferOf(servo).denominator}),
      of_command_(drive_.SettledState({start, 0, 0, 0})),
      of_load_(load_drive_.SettledState({})) {}

void ContinuousAxis::Follow(const Cubic& command, double duration_s) {
  of_command_ = drive_.Follow(of_command_, command, duration_s);
  const double displaced =
      -load_acceleration_ * servo_.velocity_time_s / servo_.position_gain_per_s;
  of_load_ = load_drive_.Follow(of_load_, {displaced, 0, 0, 0}, duration_s);
}

double ContinuousAxis::Acceleration(double commanded, double commanded_speed) const {
  const double asked = servo_.position_gain_per_s * (commanded - position()) +
                       servo_.derivative_ratio * (commanded_speed - speed()) +
                       servo_.feed_forward_ratio * commanded_speed;
  return (asked - speed()) / servo_.velocity_time_s - load_acceleration_;
}

}  // namespace intaglio::drive
