#pragma once

// The steps that drive at their limits and then wait at rest for the tick. Frame
// machine, mm. Each is made of courses of interpolator.h:
//   TimeOptimalProgram   one course that the axes share, with UnitStepLimits: a straight
//                        way in the shortest time there is for it, ch. 6.2.6
//   InterpolatorProgram  every axis its own, (99)-(104), with its own limits: no slower,
//                        but the way is a bend, as the short axes arrive first. Where
//                        the length of a vector is limited, the axes that move are
//                        lowered in one proportion until all of them at once keep it.
// Steps along one axis are the same motion in both.
//
// Arcs meet on a grid of kGridSubticks, about 1/1000 tick: speed and acceleration of a
// course are lowered until its times fall on it, so a step may last three grid lengths
// longer than T of (81). Without the grid the axes' knots come so near each other that
// the last bit of a coordinate shows as acceleration between them.

#include "engrave/motion/axis/limits.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

inline constexpr std::uint64_t kGridSubticks = 64;

/// 1 to 4 segments a step: three arcs, the wait.
class TimeOptimalProgram : public StepProgram {
 public:
  TimeOptimalProgram(const Limits& limits, double rate_hz)
      : limits_(limits), rate_hz_(rate_hz) {}
  std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                       std::vector<Segment>& out) const override;

 private:
  Limits limits_;
  double rate_hz_;
};

/// Up to 10 segments a step: three arcs an axis, the wait.
class InterpolatorProgram : public StepProgram {
 public:
  InterpolatorProgram(const Limits& limits, double rate_hz)
      : limits_(limits), rate_hz_(rate_hz) {}
  std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                       std::vector<Segment>& out) const override;

 private:
  Limits limits_;
  double rate_hz_;
};

}  // namespace intaglio::motion
