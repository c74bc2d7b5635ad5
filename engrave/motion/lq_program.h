#pragma once

// Steps by dynamic programming, Trochimczuk 2008 ch. 6.2.7, with both ends fixed: of all
// courses from rest to rest in the time the one of minimum
//   integral of u^2 + w^2 v^2,   x' = v, v' = u,   w = a_max / v_max of the step
// by the recursion of lq.h, 8 to 512 stages of constant acceleration, which a segment is
// exactly. All axes share the course, so the way is straight. The source gives no
// weights: w is that of a plant and weights (program_options.h), else the ratio of the
// limits, and the time is the fewest ticks that keep them.
//
// What is true of this program:
// - With no weight of the speed the optimum is the cubic curve with zero end speeds,
//   (16)-(20): that is the profile cubic, and not built again. Steps of a time below 1 /
//   w come near it.
// - Longer steps rise to a cruise as 1 - exp(-w t), at both limits just so, and take up
//   to V / a longer than the trapezoid, with no jump of the acceleration but at the ends.
// - Friction adds nothing: for v' = alpha v + beta u the integrand r u^2 + q v^2 is that
//   without friction and with q + r alpha^2 / beta^2, but for the derivative of v^2,
//   whose integral between two rests vanishes. The weight may be read as friction.
// - This case has a closed form, v ~ cosh(w T / 2) - cosh(w (T / 2 - t)), which the tests
//   compare with; the recursion takes any stage.

#include <optional>

#include "engrave/motion/axis/limits.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

class LqProgram : public StepProgram {
 public:
  /// rate_per_s: w >= 0; absent: of the limits.
  LqProgram(const Limits& limits, double rate_hz, std::optional<double> rate_per_s = {})
      : limits_(limits), rate_hz_(rate_hz), rate_per_s_(rate_per_s) {}
  std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                       std::vector<Segment>& out) const override;

 private:
  Limits limits_;
  double rate_hz_;
  std::optional<double> rate_per_s_;
};

}  // namespace intaglio::motion
