#pragma once

// Commands that make a stage follow the plan: the inverse of its axes' drive
// (inverse_drive.h), segment by segment. Frame machine, mm.
//
// On a segment the plan is cubic, so the command is cubic, too, but for the transients of
// a drive with zeros. Where the acceleration of the plan jumps, at knots, the command of
// a first-order drive and of one with one zero less than poles has a kink, that of a
// second-order drive a jump, which a position-velocity-time controller cannot do: it gets
// the mean of both sides. With J the jump of the acceleration, at most about lag^2 J / 2
// of a first order and J / (2 w^2) of a second order is left of it at a point: 0.3 um for
// the ELS-03, 12 um for 120 Hz and the same accelerations. The test measures both.
// error_prediction.h says what is left of a plan.

#include <array>
#include <optional>
#include <vector>

#include "engrave/drive/drive.h"
#include "engrave/motion/commands/inverse_drive.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

/// Streams segments of a plan into segments of commands, one segment behind. Durations,
/// points and pulses are unchanged, but for ticks at the end; rest stays rest.
class DriveCompensation {
 public:
  /// The plan begins at rest at `start`. The drives are read here alone. Throws
  /// PreconditionError unless rate_hz > 0.
  DriveCompensation(const drive::AxisDrives& drives, double rate_hz,
                    const KnotState& start);

  void Append(const Segment& planned, std::vector<Segment>& out);
  /// Adds the segment still held, which ends at rest; of a drive with transients behind
  /// it segments of a tick in which the command comes to rest, too.
  void Finish(std::vector<Segment>& out);
  /// How many ticks Finish added.
  std::uint64_t tail_ticks() const { return tail_ticks_; }

 private:
  /// The last segment of the plan and those behind it; returns the very last.
  Segment FollowTail(Segment last, std::vector<Segment>& out);
  bool continuous() const;
  drive::Cubic CourseOf(const KnotState& from, const Segment& to, int axis) const;
  /// The command of an axis at the knot between two segments.
  InverseDrive::Command AtKnot(int axis, const Segment& before, const Segment& behind);

  std::array<InverseDrive, 3> inverses_;
  double rate_hz_;
  KnotState from_;  ///< of the plan, where the held segment begins
  std::optional<Segment> held_;
  std::uint64_t tail_ticks_ = 0;
};

}  // namespace intaglio::motion
