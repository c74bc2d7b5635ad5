#pragma once

// Commands that make a lagging stage be where the plan is. A stage that follows its
// command with a first-order lag, x' = (c - x) / lag, passes a point at speed v a
// distance lag v late: 16 um at 80 mm/s and 0.2 ms. Commanded
//   c = p + lag p'
// it follows p exactly. Frame machine, mm.
//
// On a segment c is cubic as p is. Only where the acceleration jumps, at knots, c' would
// jump, which a position-velocity-time controller cannot do: it gets the mean of both
// sides, and what is left of that at the point is below half a micrometre for the lags
// and accelerations of such machines (the test measures it).

#include <optional>
#include <vector>

#include "engrave/motion/segment.h"

namespace intaglio::motion {

/// Streams segments of a plan into segments of commands, one segment behind. Durations,
/// points and pulses stay what they are; rest stays rest.
class LagCompensation {
 public:
  /// lag_s >= 0; 0 leaves all as it is. The plan begins at rest at `start`.
  LagCompensation(double lag_s, double rate_hz, const KnotState& start);

  void Append(const Segment& planned, std::vector<Segment>& out);
  /// Adds the segment still held, which ends at rest.
  void Finish(std::vector<Segment>& out);

 private:
  Segment Commanded(const Vec3& acceleration_mm_s2) const;

  double lag_s_;
  double rate_hz_;
  KnotState from_;  ///< of the plan, where the held segment begins
  std::optional<Segment> held_;
};

}  // namespace intaglio::motion
