#pragma once

// The plan of a job as if it were never paused: used for its forecast, and to compare two
// runs of one job.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/motion/planner.h"
#include "proto/task.pb.h"

namespace intaglio {

struct PlanInput {
  /// The axes at the points, in the order of engraving; at least one.
  PointList machine_points_mm;
  motion::PlanOptions options;
  /// Of each point, for the stage rests where they change; empty: they never do.
  std::vector<ChannelMask> masks = {};
  /// The move of the focus, mm, for a move of the axes by one unit: for the moves of
  /// points, which the planner knows on the axes.
  double focus_mm_per_axis_unit = 1;
  /// Takes each segment, as commanded; default: nobody.
  std::function<void(const motion::Segment&)> follow = {};
};

/// How far from its points the focus will be, by the profile's drives
/// (predicted_errors.h).
struct PredictedSummary {
  double rms_um = 0, max_um = 0;
  double wrong_mechanics_max_um = 0;  ///< max_um with wrong mechanics
};

struct PlanSummary {
  std::uint64_t ticks = 0;  ///< to the last point
  std::string checksum;     ///< CRC-32 of all segments, hexadecimal
  motion::PointMoves moves;
  std::vector<std::uint32_t> point_ticks = {};  ///< of each point, from the start
  std::optional<PredictedSummary> predicted = {};
};

/// A million points with limits of the jerk take seconds. `progress`: every 256 points,
/// done and total; kCancelled when it returns false.
Result<PlanSummary> Summarize(const PlanInput& plan, const ProgressSink& progress);

/// The same with the predicted errors; none of a job whose pulses fire at the place.
/// `plan`: of that job.
Result<PlanSummary> Summarize(const FrozenJob& job, PlanInput plan,
                              const ProgressSink& progress);

}  // namespace intaglio
