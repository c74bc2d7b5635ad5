#include "engrave/motion/step_limits.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "engrave/motion/axis/jerk_reach.h"
#include "engrave/motion/segments/segment.h"

// Shares. Scatter moves mostly in the plane of x and y, in any direction: three of the
// boxes leave z little and split the rest, one is a cube, one is for moves along z. The
// acceleration of a turn is across the velocity, so each split of one goes with each of
// the other. An axis whose own limit is below its share leaves the rest to the others.

namespace intaglio::motion {
namespace {

/// The cost of a limit, in steps of one tick, by experiment: the maximum needed was 14.
constexpr double kNodeCost = 16;
/// Steps of the grid, by experiment: a cruise was faster by acceleration / 1.8 at most.
constexpr double kNodeSteps = 3;
constexpr double kFlatShare = 0.2;  ///< of z, in the boxes for the plane

/// Shares of x, y and z.
std::array<Vec3, 5> ShareVectors() {
  const double plane = std::sqrt(1 - kFlatShare * kFlatShare);
  const auto flat = [&](double degrees) {
    const double angle = degrees * M_PI / 180;
    return Vec3(plane * std::cos(angle), plane * std::sin(angle), kFlatShare);
  };
  const double across = kFlatShare, along = std::sqrt(1 - 2 * across * across);
  return {flat(45), flat(15), flat(75), Vec3::Constant(std::sqrt(1.0 / 3)),
          Vec3(across, across, along)};
}

/// The largest box of these shares in the ball and the box `most`.
Vec3 Inscribed(const Vec3& shares, double length, const Vec3& largest) {
  Vec3 box = (length * shares).cwiseMin(largest);
  for (int round = 0; round < 3; ++round) {
    double rest = length * length, open = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (box[axis] >= largest[axis])
        rest -= largest[axis] * largest[axis];
      else
        open += shares[axis] * shares[axis];
    }
    if (open == 0 || rest <= 0) break;
    const double scale = std::sqrt(rest / open);
    for (int axis = 0; axis < 3; ++axis) {
      if (box[axis] < largest[axis])
        box[axis] = std::min(scale * shares[axis], largest[axis]);
    }
  }
  return box;
}

/// The boxes for one length; the whole one where the length is no limit.
std::vector<Vec3> Boxes(double length, const Vec3& largest) {
  if (largest.norm() <= length) return {largest};
  std::vector<Vec3> boxes;
  for (const Vec3& shares : ShareVectors()) {
    boxes.push_back(Inscribed(shares, length, largest));
  }
  return boxes;
}

double MinJerk(const Limits& limits) { return limits.max_jerk_mm_s3.minCoeff(); }

std::uint64_t GridSubticks(const Limits& limits, double rate_hz) {
  constexpr double kGridSeconds = 0.2e-6, kBitMm = 2.2e-14;
  double seconds = kGridSeconds;
  if (MinJerk(limits) < kUnlimited) {
    seconds = std::max(seconds, std::cbrt(24 * kBitMm / (1e-3 * MinJerk(limits))));
  }
  const auto grid = std::bit_ceil(
      static_cast<std::uint64_t>(std::ceil(seconds * rate_hz * kSubticksPerTick)));
  return std::min<std::uint64_t>(grid, kSubticksPerTick / 32);
}

Limits Planned(const Limits& limits, double rate_hz, std::uint64_t grid_subticks) {
  const double grid_ticks = static_cast<double>(grid_subticks) / kSubticksPerTick;
  Limits planned = limits;
  double arc_steps = 2;
  planned.max_acceleration_mm_s2 *= 1 - 4 * grid_ticks;
  if (MinJerk(limits) < kUnlimited) {
    // The cost of moving the nodes of the acceleration to the grid (step_course.cc): a
    // ramp to full acceleration may get shorter by a step of the grid.
    const double kept = 1 - kNodeCost * grid_ticks, grid_s = grid_ticks / rate_hz;
    planned.max_acceleration_mm_s2 = limits.max_acceleration_mm_s2 * kept;
    arc_steps = kNodeSteps;
    for (int axis = 0; axis < 3; ++axis) {
      double& jerk = planned.max_jerk_mm_s3[axis];
      if (jerk == kUnlimited) continue;
      jerk *= kept / (1 + grid_s * jerk / limits.max_acceleration_mm_s2[axis]);
    }
  }
  // A longer arc makes the cruise faster by no more than it accelerates meanwhile.
  planned.max_speed_mm_s -=
      planned.max_acceleration_mm_s2 * (arc_steps * grid_ticks / rate_hz);
  return planned;
}

}  // namespace

std::vector<StepLimits> StepLimitsOf(const Limits& limits, double rate_hz) {
  std::vector<StepLimits> choices;
  for (const Vec3& speed : Boxes(limits.max_speed_norm_mm_s, limits.max_speed_mm_s)) {
    for (const Vec3& acceleration :
         Boxes(limits.max_acceleration_norm_mm_s2, limits.max_acceleration_mm_s2)) {
      StepLimits choice{limits, limits, GridSubticks(limits, rate_hz)};
      choice.whole.max_speed_mm_s = speed;
      choice.whole.max_acceleration_mm_s2 = acceleration;
      choice.planned = Planned(choice.whole, rate_hz, choice.grid_subticks);
      choices.push_back(choice);
    }
  }
  return choices;
}

bool NearWalls(const std::vector<StepLimits>& choices, const Box3& extent_mm,
               double rate_hz) {
  for (const StepLimits& limits : choices) {
    for (int axis = 0; axis < 3; ++axis) {
      const double top = limits.planned.max_speed_mm_s[axis];
      for (const double end : {extent_mm.min_mm[axis], extent_mm.max_mm[axis]}) {
        if (SpeedsAt(end, axis, limits, rate_hz).hi < top) return true;
      }
    }
  }
  return false;
}

bool IsPlain(const std::vector<StepLimits>& choices) {
  return choices.size() == 1 && MinJerk(choices[0].whole) == kUnlimited;
}

SpeedInterval SpeedsAt(double position_mm, int axis, const StepLimits& limits,
                       double rate_hz, double slack_mm) {
  const double near_mm = std::min(position_mm - limits.whole.travel_mm.min_mm[axis],
                                  limits.whole.travel_mm.max_mm[axis] - position_mm);
  const double top = limits.planned.max_speed_mm_s[axis];
  if (near_mm == kUnlimited) return {-top, top};
  // Arcs on the grid brake by at most one step of it later.
  const double grid_s =
      static_cast<double>(limits.grid_subticks) / (kSubticksPerTick * rate_hz);
  const double braking_mm = std::max(near_mm - 2 * top * grid_s, 0.0) + slack_mm;
  const double speed =
      limits.jerk_limited(axis)
          ? PulseSpeedWithin(braking_mm / 1.5, JerkLimitsOf(limits.planned, axis))
          : std::sqrt(2 * limits.planned.max_acceleration_mm_s2[axis] * braking_mm);
  return {-std::min(speed, top), std::min(speed, top)};
}

}  // namespace intaglio::motion
