#pragma once

// What a job of marks comes to, for who looks at it before it is made. Of a web no more
// marks than those of some repeats are in memory: they are made and ordered repeat by
// repeat, and made again where they are asked for, so that a table may have many rows.

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/marks/mark_times.h"
#include "services/job/marks/repeat_marks.h"
#include "services/job/marks/web_plan.h"
#include "services/job/marks/web_run.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

struct PlanningProgress {
  ProgressSink made;     ///< in repeats
  ProgressSink ordered;  ///< of a web in orders that are tried
};

class PlannedMarks {
 public:
  /// The marks of MakeJobMarks in the order of OrderJobMarks, with the errors and the
  /// warnings of both. `executor`: of a web, for its repeats.
  static Result<PlannedMarks> Make(const JobSpec& job, const MachineSpec& machine,
                                   std::vector<FileBytes> files, const ReadLimits& limits,
                                   const Executor& executor, Warnings& warnings,
                                   const PlanningProgress& progress);

  const HeadFigures& head() const { return head_; }
  const std::vector<mark::Pen>& pens() const { return pens_; }
  std::size_t mark_count() const { return mark_count_; }
  /// Of each pen.
  const std::vector<std::size_t>& counts() const { return counts_; }
  /// The same of lit ways: of rows their dots (mark::LitWaysOf).
  const std::vector<std::size_t>& way_counts() const { return way_counts_; }
  const MarkTimes& times() const { return times_; }
  /// Of a job with a web; errors as of WebRunOf.
  const std::optional<Result<WebRun>>& web() const { return web_; }

  /// Calls `each` with the marks in their order and their numbers in it, from 0, until it
  /// returns false; those that begin beyond `max_web_mm` are left out.
  Status ForEach(const std::function<bool(std::size_t number, const mark::Mark&)>& each,
                 double max_web_mm = std::numeric_limits<double>::infinity());

 private:
  PlannedMarks(const JobSpec& job, const MachineSpec& machine);
  Status PlanWeb(const JobSpec& job, const ScanHead& head, const Executor& executor,
                 Warnings& warnings, const PlanningProgress& progress);
  Status PlanAtRest(const JobSpec& job, const MachineSpec& machine,
                    std::vector<FileBytes> files, const ReadLimits& limits,
                    Warnings& warnings, const PlanningProgress& progress);
  /// The error of a repeat that does not fit into the field; `first`: number of its mark.
  Status CheckRepeat(std::size_t repeat, std::size_t first);
  Result<std::vector<mark::Mark>> OrderedRepeat(RepeatMarks& repeats, std::size_t repeat,
                                                Warnings& warnings) const;

  HeadFigures head_;
  bool may_reverse_;
  double pitch_mm_;
  std::vector<mark::Pen> pens_;
  std::size_t mark_count_ = 0;
  std::vector<std::size_t> counts_, way_counts_;
  MarkTimes times_;
  std::optional<Result<WebRun>> web_;

  std::vector<mark::Mark> marks_;         // of a piece at rest
  std::optional<RepeatMarks> repeats_;    // of a web
  std::vector<std::size_t> repeat_ends_;  // number of the mark behind each repeat
  std::vector<MarkRange> ranges_;         // in their order
};

}  // namespace intaglio
