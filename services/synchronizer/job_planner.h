#pragma once

// The long computations of a task, each in a thread of its own beside the loop, which
// only polls them: first the preparation (job_preparation.h), then, while the job is
// engraved already, the summary of its whole plan (plan_summary.h).
//
//   Begin --> preparing --TakePrepared--> summary is computed --> summary()
//     ^           |                               |
//     +--Abandon--+-------------Abandon-----------+
//
// An abandoned computation runs to its end without a result; a task begun meanwhile waits
// for that, because both may use the same folder. No function waits but the destructor.
// Used from one thread.

#include <memory>
#include <optional>
#include <vector>

#include "services/platform/host/threads/computation.h"
#include "services/synchronizer/job_preparation.h"

namespace intaglio::synchronizer {

class JobPlanner {
 public:
  /// Abandons another task.
  void Begin(PreparationTask task);
  void Abandon();
  /// Once per task, when it is prepared or has failed, and nullopt before and after. From
  /// then on the summary is computed. To be called in every turn of the loop.
  std::optional<Result<PreparedJob>> TakePrepared();
  /// The summary of the task that was prepared last; null until it is computed, and if
  /// there is none. To be called in every turn until it is there.
  const Result<PlanSummary>* summary();

 private:
  using Preparation = host::Computation<PreparedJob>;
  using Summary = host::Computation<PlanSummary>;
  void DropEnded();

  std::optional<PreparationTask> waiting_;
  std::unique_ptr<Preparation> preparation_;
  std::unique_ptr<Summary> summary_;
  std::optional<Result<PlanSummary>> summarized_;
  std::vector<std::unique_ptr<Preparation>> abandoned_preparations_;
  std::vector<std::unique_ptr<Summary>> abandoned_summaries_;
};

}  // namespace intaglio::synchronizer
