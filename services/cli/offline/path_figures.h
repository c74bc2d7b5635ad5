#pragma once

// The figures of a path and of the motion along it, for people and for programs.

#include <functional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/motion/segments/segment.h"
#include "proto/plan_report.pb.h"
#include "proto/task.pb.h"

namespace intaglio::cli {

/// Takes the segments as they are planned; an error ends the planning.
using SegmentSink = std::function<Status(const motion::Segment&)>;

/// The path's own figures and the job's machine; no motion yet. path_mm: frame glass, in
/// the order of engraving, not empty.
PlanReport DescribePath(const FrozenJob& job, const PointList& path_mm);

/// Plans the job's motion, from rest at the first point as the synchronizer does, and
/// checks it with the independent verifier; holds only some segments at a time. The
/// motion is that of the stage itself: commands to a stage that lags lead it
/// (engrave/motion/commands/drive_compensation.h). `path`: the axes at the points, not
/// empty; the figures of axes that turn are those of the focus farthest from their pivot.
/// Errors are those of `sink`, and kCancelled. `errors_um`, where it is not null: how far
/// from each point it will be made, in the glass, as the profile's drive predicts it;
/// empty where nothing is predicted (predicted_errors.h).
Result<PlannedMotion> PlanMotion(const FrozenJob& job, const PointList& path,
                                 const SegmentSink& sink, const ProgressSink& progress,
                                 std::vector<double>* errors_um = nullptr);

/// The job with each of the motion profiles but its own.
std::vector<FrozenJob> WithOtherPlanners(const FrozenJob& job);

/// No violation of the order, nor in the job's motion, the first.
bool IsSound(const PlanReport& report);

/// An aligned block: the path and the first motion.
std::string FiguresOf(const PlanReport& report);
/// An aligned table of all motions, a heading and a line each.
std::string ComparisonOf(const PlanReport& report);
std::string JsonOf(const PlanReport& report);

}  // namespace intaglio::cli
