#pragma once

// Motion that passes every point at a tick without having to stop there, as fast as the
// limits of the axes allow. Frame machine, mm. All limits that are set are kept
// (limits.h; step_limits.h states what is exact).
//
// It plans a window of points at a time to rest at the window's last point, returns the
// first part of it and plans the rest again together with the points added since. So the
// motion returned can be continued to rest at any time, a path of any length is planned
// while it runs, and memory is bounded.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/motion/point_shift.h"
#include "engrave/motion/segments/segment.h"
#include "engrave/motion/segments/step_judge.h"
#include "engrave/motion/sweep_course.h"
#include "engrave/motion/tick_labels.h"

namespace intaglio::motion {

struct TickPlannerOptions {
  LabelOptions labels;
  /// Points planned at once, >= 2.
  int window_points = 512;
  /// Of these, points planned again with the next ones, < window_points. What comes
  /// later changes the best way only some ten points back. Where the third axis sweeps
  /// there are as many as it needs for a way across its tolerance, at most 4096, and the
  /// window has four times as many: it has to begin in time.
  int look_ahead_points = 64;
  /// Passes that lower acceleration without costing a tick (speed_choice.h).
  int sweeps = 2;
  /// How far a point may be moved where that saves ticks, >= 0.
  double tolerance_mm = 0;
  /// How far above or below a point, besides, the third axis may pass it so that it need
  /// not stop at its height (sweep_course.h), >= 0. The last point before a rest is met
  /// at its height.
  double sweep_mm = 0;
  /// Of accelerations, each smaller than the one before, from which steps that a judge
  /// finds too fast take theirs, >= 1.
  int acceleration_levels = 1;
};

/// Options that fit a rate: more labels where a step takes more ticks.
TickPlannerOptions OptionsForRate(double rate_hz);

/// Streams: target in, segments out. Not for use by two threads at once.
class TickPlanner {
 public:
  /// Starts at `start`, at a whole tick. rate_hz > 0: the lamp's rate, 1 .. 50000. A
  /// start velocity must be one from which the way can be made within the limits.
  TickPlanner(const Limits& limits, double rate_hz, const TickPlannerOptions& options,
              const KnotState& start);

  /// Steps that `judge` finds too fast get a smaller acceleration; it has to live as long
  /// as the plan goes on. Null: all are slow enough.
  void SetJudge(const StepJudge* judge) { judge_ = judge; }

  /// Takes the next target; adds the segments that are settled, those of a whole window
  /// at once. The last segment of a step carries `point` and `pulse`.
  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out);

  /// Adds all that is left and the end of the program, at rest at the last target. The
  /// next Append starts from there.
  void Finish(std::vector<Segment>& out);

  /// End of the segments returned so far.
  const KnotState& state() const { return state_; }
  /// Ticks of the segments returned so far.
  std::uint64_t ticks() const { return ticks_; }
  /// Shifts of the points returned so far.
  const PointMoves& moves() const { return moves_; }

 private:
  struct Target {
    Vec3 position_mm;
    std::int32_t point;
    bool pulse;
  };

  /// A way through the targets and the ticks of its steps.
  struct Way {
    std::vector<Vec3> points_mm;
    std::vector<Vec3> steps_mm;
    std::vector<TimedStep> timed;
    bool near_walls = false;
    std::uint64_t ticks = 0;
  };

  /// `to_end`: the last target is the end of the program.
  void PlanWindow(bool to_end);
  void PlanOnce(bool to_end);
  /// Until the judge agrees, or for a number of times.
  void SlowDown(bool to_end);
  void AddSegments(std::size_t count, std::vector<Segment>& out) const;
  /// Fills in all but the points.
  void PlanThrough(Way& way);
  void SweepPast(bool to_end);
  void MovePoints();
  void HandOut(std::size_t count, std::vector<Segment>& out);

  std::vector<StepLimits> choices_;  ///< Of all levels.
  std::vector<StepLimits> full_;     ///< Of the first.
  double rate_hz_;
  TickPlannerOptions options_;
  KnotState state_;
  std::uint64_t ticks_ = 0;
  TickLabels labels_;
  std::vector<Target> targets_;  ///< Not yet returned.
  Way way_;
  Way moved_way_;  ///< Tried, and better or not.
  Way best_way_;   ///< The best that sweeps.
  SweepCourse sweep_;
  std::vector<double> heights_mm_, seconds_, swept_mm_;  ///< The window's points.
  PointMoves moves_;
  std::vector<Vec3> ends_mm_s_;
  const StepJudge* judge_ = nullptr;
  std::vector<std::uint32_t> levels_;  ///< Of the window's steps; empty: 0.
};

}  // namespace intaglio::motion
