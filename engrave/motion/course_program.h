#pragma once

// The profiles of profile.h, triangle to mix: one course in time that the axes share, so
// the way is straight. A step takes n = WholeTicks(T) whole ticks, T the profile's
// minimum time, and is then stretched to fill them: the stage never waits at a point and
// never accelerates more than necessary.

#include "engrave/motion/axis/limits.h"
#include "engrave/motion/axis/profile.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

/// 1 to 3 segments a step, more when it lasts longer than kMaxSegmentTicks.
class CourseProgram : public StepProgram {
 public:
  /// `profile` is kTriangle, kTrapezoid, kCubic or kMix.
  CourseProgram(const Limits& limits, double rate_hz, Profile profile)
      : limits_(limits), rate_hz_(rate_hz), profile_(profile) {}

  std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                       std::vector<Segment>& out) const override;

 private:
  Limits limits_;
  double rate_hz_;
  Profile profile_;
};

}  // namespace intaglio::motion
