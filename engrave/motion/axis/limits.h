#pragma once

// The limits of the stage, frame machine. Each axis has its own drive, so the limits are
// per axis: a move is limited by whichever axis is at its limit.

#include <limits>

#include "engrave/core/geometry.h"

namespace intaglio::motion {

/// A limit that is not set.
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Limits of the three axes, > 0; speed and acceleration per axis are finite. The rest
/// are options, which the planner that does not stop (tick_planner.h) keeps; the stopping
/// one (stop_and_go.h), whose profiles are the source's, keeps neither jerk nor lengths.
struct Limits {
  Vec3 max_speed_mm_s = Vec3::Constant(80.0);            ///< ELS-03 as published.
  Vec3 max_acceleration_mm_s2 = Vec3::Constant(7000.0);  ///< Above 7500 it shakes.
  /// With one axis limited, acceleration is continuous on that axis.
  Vec3 max_jerk_mm_s3 = Vec3::Constant(kUnlimited);
  double max_speed_norm_mm_s = kUnlimited;          ///< Of the vector's length.
  double max_acceleration_norm_mm_s2 = kUnlimited;  ///< Of the vector's length.
  /// The box that the motion must not leave, between the points too. Not empty.
  Box3 travel_mm = {Vec3::Constant(-kUnlimited), Vec3::Constant(kUnlimited)};
};

/// Throws PreconditionError unless every limit is positive and those of speed and
/// acceleration per axis are finite.
void RequireUsable(const Limits& limits);

/// The limits at which the whole motion runs `ratio` times as fast, > 0: speeds times the
/// ratio, accelerations times its square, jerks times its cube; above 1 none beyond that
/// of `ceiling`, which is at least `limits`. travel_mm stays.
Limits LimitsAtSpeed(const Limits& limits, const Limits& ceiling, double ratio);

}  // namespace intaglio::motion
