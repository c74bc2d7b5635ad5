#include "services/discretizer/discretize_job.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "services/discretizer/result_checksum.h"
#include "services/job/marks/mark_maker.h"
#include "services/job/models/discretize_outcome.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/stage/mark_batch.h"

namespace intaglio::discretizer {

Result<std::shared_ptr<const PreparedJob>> PrepareJob(const FrozenJob& job,
                                                      std::vector<FileBytes> files,
                                                      const ReadLimits& limits,
                                                      const ProgressSink& progress) {
  auto sources = INTAGLIO_TRY(MakeSources(job.job(), std::move(files), limits, progress));
  return std::make_shared<const PreparedJob>(PreparedJob{job.job(), std::move(sources)});
}

Result<host::StageResult> MakeMarksOf(const FrozenJob& job, std::vector<FileBytes> files,
                                      const ReadLimits& limits,
                                      const ProgressSink& progress) {
  host::StageResult result;
  Warnings warnings;
  result.marks = INTAGLIO_TRY(
      MakeMarks(job.job(), job.machine(), std::move(files), limits, warnings, progress));
  INTAGLIO_TRY(host::CheckMarkRoom(*result.marks));
  DiscretizeOutcome& outcome = *result.outcome.mutable_discretize();
  outcome.set_point_count(result.size());
  outcome.set_checksum(ChecksumOf(result));
  AddTo(*outcome.mutable_warnings(), warnings);
  return result;
}

Result<host::StageResult> DiscretizePart(const PreparedJob& prepared,
                                         const discretize::Part& part,
                                         const Executor& executor,
                                         const ProgressSink& progress) {
  auto made = INTAGLIO_TRY(discretize::MakeCloud(
      prepared.sources.sources, CloudOptionsOf(prepared.job), part, executor, progress));
  // One of several parts may be empty; the sorter refuses a job without points.
  if (part.count == 1 && made.cloud.size() == 0) {
    return tl::unexpected(discretize::NoPoints());
  }
  host::StageResult result;
  *result.outcome.mutable_discretize() = OutcomeOf(prepared.sources, made, part);
  result.cloud = std::move(made.cloud);
  result.outcome.mutable_discretize()->set_checksum(ChecksumOf(result));
  return result;
}

}  // namespace intaglio::discretizer
