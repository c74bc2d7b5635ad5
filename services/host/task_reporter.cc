#include "services/host/task_reporter.h"

#include <algorithm>
#include <vector>

#include "services/bus/samples.h"
#include "services/host/log.h"

namespace intaglio::host {
namespace {
using bus::Borrow;
constexpr std::chrono::milliseconds kPeriod{100};
// A job service that was away asks for the outcome of what it had handed out, not for
// everything that ever was.
constexpr std::size_t kKeptTasks = 256;
}  // namespace

TaskReporter::TaskReporter(bus::Bus& bus, std::string worker, intaglio_Stage stage)
    : writer_(bus, bus::kTaskStatus), worker_(std::move(worker)), stage_(stage) {}

void TaskReporter::Accept(const std::string& job_uid, std::uint32_t attempt,
                          TaskPart part, TimePoint now) {
  job_uid_ = job_uid;
  attempt_ = attempt;
  part_ = part;
  next_ = now + kPeriod;
  Remember();
  Publish(intaglio_TASK_ACCEPTED, {}, {ErrorCode::kInvalidValue, "", ""}, "");
}

void TaskReporter::Run(const TaskProgress& progress, TimePoint now) {
  if (now < next_) return;
  next_ = now + kPeriod;
  Publish(intaglio_TASK_RUNNING, progress, {ErrorCode::kInvalidValue, "", ""}, "");
}

void TaskReporter::Done(const TaskProgress& progress, StageOutcome outcome) {
  outcome.set_elapsed_s(progress.elapsed_s);
  Publish(intaglio_TASK_DONE, progress, {ErrorCode::kInvalidValue, "", ""},
          outcome.SerializeAsString());
}

void TaskReporter::Failed(const TaskProgress& progress, const Error& error) {
  Publish(intaglio_TASK_FAILED, progress, error, "");
}

void TaskReporter::Publish(intaglio_TaskState state, const TaskProgress& progress,
                           const Error& error, const std::string& outcome) {
  const std::string code = state == intaglio_TASK_FAILED ? ErrorCodeName(error.code) : "";
  const std::vector<std::uint8_t> bytes(outcome.begin(), outcome.end());
  intaglio_TaskStatus sample{};
  sample.job_uid = Borrow(job_uid_);
  sample.stage = stage_;
  sample.worker = Borrow(worker_);
  sample.part = part_.index;
  sample.part_count = part_.count;
  sample.attempt = attempt_;
  sample.part_attempt = part_.attempt;
  sample.state = state;
  sample.done_count = progress.done_count;
  sample.total_count = progress.total_count;
  sample.elapsed_s = progress.elapsed_s;
  sample.error_code = Borrow(code);
  sample.message = Borrow(error.message);
  Borrow(sample.outcome, bytes);
  if (auto written = writer_.Write(sample); !written) {
    LogWarning("task status of job {}: {}", job_uid_, written.error().message);
  }
}

void TaskReporter::Remember() {
  const std::pair told(job_uid_, part_.index);
  if (std::find(told_.begin(), told_.end(), told) != told_.end()) return;
  told_.push_back(told);
  if (told_.size() <= kKeptTasks) return;
  intaglio_TaskStatus sample{};
  sample.job_uid = Borrow(told_.front().first);
  sample.stage = stage_;
  sample.worker = Borrow(worker_);
  sample.part = told_.front().second;
  (void)writer_.Dispose(sample);
  told_.pop_front();
}

}  // namespace intaglio::host
