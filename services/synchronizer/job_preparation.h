#pragma once

// What a task takes between its path and its engraving: the path checked, the axes at its
// points computed, the job's folder written, its journal read and opened. It takes
// seconds for millions of points or on a slow disk, so it is for a thread of its own;
// nothing here is shared with the loop of the synchronizer.

#include <optional>
#include <string>

#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/job/plan/plan_summary.h"
#include "services/synchronizer/engraving.h"

namespace intaglio::synchronizer {

struct PreparationTask {
  /// With the machine's own profile in it.
  FrozenJob job;
  /// In the order of engraving, frame glass, mm. None: the job was begun before, and its
  /// path is read from its folder.
  std::optional<PointCloud> path;
  /// See EngravingJob.
  std::string block_misfit;
  /// With `path` none: nothing of the job was made yet, and its folder gets `job` anew.
  bool begins_anew = false;
};

struct PreparedJob {
  EngravingJob engraving;
  std::unique_ptr<JournalWriter> journal;
  /// What Summarize takes of the whole path.
  FrozenJob job;
  PlanInput plan;
};

/// `progress` is asked between two steps whether it is still wanted. Errors: those of
/// ReadPath, CheckedAxes, ChannelsOfPoints, OpenJournal and WritePlan; kInvalidValue for
/// a path without points; kCancelled.
Result<PreparedJob> PrepareJob(PreparationTask task, const ProgressSink& progress);

}  // namespace intaglio::synchronizer
