#pragma once

// Steps that leap from point to point on a parabola, the program of Trochimczuk 2008 ch.
// 6.2.4 and 6.2.6: x5 runs along the line that joins the points, 2b is their distance,
// and x3, in the source the axis that lifts the arm, is across it: upwards in the frame
// machine, +z, or along +x where the step itself is within 6 degrees of upright. The
// speed along the arc is the trapezoid (45) in proportions of the least time (86), with
// a0 and V0 what the axes allow along the arc. Frame machine, mm.
//
// The source leaves h and k open. Here h is what ProgramOptions give, at most half of the
// distance, else a tenth of the distance and 1 mm at most; and less, or below the line
// instead of above it, where the travel of the stage ends.
//
// The forces of parabola.h are internal to the drives; a controller gets positions and
// speeds. So the time is scaled to the first whole ticks at which no axis, with the
// centripetal acceleration V^2 kappa added, passes a limit, and the program is cut into
// cubic pieces that deviate from it by less than kMaxDeviationMm.

#include <optional>

#include "engrave/motion/axis/limits.h"
#include "engrave/motion/axis/parabola.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

/// Half of the 0.1 um that count: the deviation is measured at samples.
inline constexpr double kMaxDeviationMm = 5e-5;

class ParabolaProgram : public StepProgram {
 public:
  ParabolaProgram(const Limits& limits, double rate_hz,
                  std::optional<double> height_mm = {})
      : limits_(limits), rate_hz_(rate_hz), height_mm_(height_mm) {}
  std::uint64_t Append(const Vec3& from_mm, const Vec3& to_mm,
                       std::vector<Segment>& out) const override;

 private:
  Limits limits_;
  double rate_hz_;
  std::optional<double> height_mm_;
};

/// Where the arc of a step rises to: across the step, of length h; zero for a straight
/// step. Both ends are within the travel.
Vec3 ArchOfStep(const Vec3& from_mm, const Vec3& to_mm, const Box3& travel_mm,
                std::optional<double> height_mm = {});

}  // namespace intaglio::motion
