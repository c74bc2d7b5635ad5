#include "services/platform/host/stage/task_reporter.h"

#include <vector>

#include "services/platform/bus/error_code.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::host {
namespace {
using bus::Borrow;
}  // namespace

TaskReporter::TaskReporter(bus::Bus& bus, std::string worker, intaglio_Stage stage)
    : writer_(bus, bus::kTaskStatus),
      worker_(std::move(worker)),
      stage_(stage),
      kept_(worker_, stage_) {}

void TaskReporter::Accept(const StageTask& task) {
  kept_.Keep(writer_, task.job_uid, task.part.index);
  Publish(task, intaglio_TASK_ACCEPTED, {}, {ErrorCode::kInvalidValue, "", ""}, "");
}

void TaskReporter::Run(const StageTask& task, const TaskProgress& progress) {
  Publish(task, intaglio_TASK_RUNNING, progress, {ErrorCode::kInvalidValue, "", ""}, "");
}

void TaskReporter::Done(const StageTask& task, const TaskProgress& progress,
                        StageOutcome outcome) {
  outcome.set_elapsed_s(progress.elapsed_s);
  Publish(task, intaglio_TASK_DONE, progress, {ErrorCode::kInvalidValue, "", ""},
          outcome.SerializeAsString());
}

void TaskReporter::Failed(const StageTask& task, const TaskProgress& progress,
                          const Error& error) {
  Publish(task, intaglio_TASK_FAILED, progress, error, "");
}

void TaskReporter::Publish(const StageTask& task, intaglio_TaskState state,
                           const TaskProgress& progress, const Error& error,
                           const std::string& outcome) {
  const std::vector<std::uint8_t> bytes(outcome.begin(), outcome.end());
  intaglio_TaskStatus sample{};
  sample.job_uid = Borrow(task.job_uid);
  sample.stage = stage_;
  sample.worker = Borrow(worker_);
  sample.part = task.part.index;
  sample.part_count = task.part.count;
  sample.attempt = task.attempt;
  sample.part_attempt = task.part.attempt;
  sample.state = state;
  sample.done_count = progress.done_count;
  sample.total_count = progress.total_count;
  sample.elapsed_s = progress.elapsed_s;
  sample.estimate_ticks = progress.estimate_ticks;
  if (state == intaglio_TASK_FAILED) sample.error_code = bus::WireOf(error.code);
  sample.message = Borrow(error.message);
  Borrow(sample.outcome, bytes);
  if (auto written = writer_.Write(sample); !written) {
    LogWarning("task status of job {}: {}", task.job_uid, written.error().message);
  }
}

}  // namespace intaglio::host
