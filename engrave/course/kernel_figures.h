#pragma once

// What a spline kernel costs at a corner and at a change of acceleration.

#include <array>

#include "engrave/course/axis_dynamics.h"
#include "engrave/course/tracking.h"

namespace intaglio::course {

struct KernelFigures {
  /// A corner is rounded by 2 v sin(turn / 2) times this, s: the half mean |t|.
  double rounding_s = 0;
  /// Of each axis' motor, acceleration per step of the axis' speed, 1/s; per step of its
  /// acceleration, without unit.
  std::array<double, 2> motor_per_speed{}, motor_per_acceleration{};
  /// Of the load, jerk per step of its speed, 1/s^2; per step of acceleration, 1/s.
  double jerk_per_speed = 0, jerk_per_acceleration = 0;
};

KernelFigures FiguresOf(const SplineKernel& kernel, const AxisPair& axes);

}  // namespace intaglio::course
