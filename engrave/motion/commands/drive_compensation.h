#pragma once

// Commands that make a stage follow the plan: the inverse of its axes' drive
// (engrave/drive/drive.h), segment by segment. Frame machine, mm.
//
// On a segment the plan is cubic, so the command is cubic, too. Where the acceleration of
// the plan jumps, at knots, the command of a first-order drive has a kink and that of a
// second-order drive a jump, which a position-velocity-time controller cannot do: it gets
// the mean of both sides. With J the jump of the acceleration, at most about lag^2 J / 2
// of a first order and J / (2 w^2) of a second order is left of it at a point: 0.3 um for
// the ELS-03, 12 um for 120 Hz and the same accelerations. The test measures both.

#include <optional>
#include <vector>

#include "engrave/drive/drive.h"
#include "engrave/motion/segment.h"

namespace intaglio::motion {

/// Streams segments of a plan into segments of commands, one segment behind. Durations,
/// points and pulses are unchanged; rest stays rest.
class DriveCompensation {
 public:
  /// `drive` is that of each axis; null: the axes are where they are commanded. The plan
  /// begins at rest at `start`. Throws PreconditionError unless rate_hz > 0.
  DriveCompensation(const drive::Drive* drive, double rate_hz, const KnotState& start);

  void Append(const Segment& planned, std::vector<Segment>& out);
  /// Adds the segment still held, which ends at rest.
  void Finish(std::vector<Segment>& out);

 private:
  Segment Commanded(const Vec3& acceleration_mm_s2, const Vec3& jerk_mm_s3) const;

  // What the command adds to the course of its derivatives; guarantee 8 of a drive.
  double of_velocity_s_ = 0, of_acceleration_s2_ = 0, of_jerk_s3_ = 0;
  bool jerk_counts_ = false;
  double rate_hz_;
  KnotState from_;  ///< of the plan, where the held segment begins
  std::optional<Segment> held_;
};

}  // namespace intaglio::motion
