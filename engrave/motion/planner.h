#pragma once

// The motion of a way, whichever planner makes it. Frame machine, mm.

#include <cstdint>
#include <memory>
#include <vector>

#include "engrave/drive/drive.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/motion/axis/profile.h"
#include "engrave/motion/axis/program_options.h"
#include "engrave/motion/point_shift.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

struct PlanOptions {
  Limits limits;
  double rate_hz = 0;  ///< lamp sync, 1..50000
  /// Points are passed without a stop (tick_planner.h); else `profile` from rest to rest
  /// (stop_and_go.h).
  bool continuous = false;
  Profile profile = Profile::kMix;
  ProgramOptions program = {};  ///< of `profile`
  /// Regarded where the stage does not stop.
  drive::AxisDrives drives = {};
  /// How far beside its point the focus may be at most when the drives follow their
  /// commands, in the axes' units; 0: it is not regarded. Where more is predicted, the
  /// steps get smaller accelerations. Regarded where the stage does not stop.
  double error_limit = 0;
  /// False: the segments are those of the plan, for who compensates them himself.
  bool compensated = true;
  /// How far a point may be moved where that saves ticks, >= 0; regarded where the stage
  /// does not stop.
  double tolerance_mm = 0;
  /// How far above or below a point, besides, the third axis may pass it, >= 0; regarded
  /// where the stage does not stop (tick_planner.h).
  double sweep_mm = 0;
};

/// Whether a motion keeps more than the speed and the acceleration of each axis: a jerk,
/// lengths of vectors, or errors of its drives.
bool KeepsMore(const PlanOptions& options);

/// Streams: target in, commands out that may come later, in the order of the targets.
/// Not for use by two threads at once.
class Planner {
 public:
  virtual ~Planner() = default;
  virtual void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
                      std::vector<Segment>& out) = 0;
  /// Adds what is left, and the end of the program at rest.
  virtual void Finish(std::vector<Segment>& out) = 0;
  /// Ticks of all segments returned so far.
  virtual std::uint64_t ticks() const = 0;
  /// How far the returned points were moved.
  virtual PointMoves moves() const { return {}; }
};

/// Starts at rest at `start_mm`.
std::unique_ptr<Planner> MakePlanner(const PlanOptions& options, const Vec3& start_mm);

}  // namespace intaglio::motion
