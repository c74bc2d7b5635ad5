#include "services/cell/task_publisher.h"

#include <vector>

#include "services/platform/bus/samples.h"

namespace intaglio::cell {
namespace {

using bus::Borrow;
constexpr std::chrono::milliseconds kTaskPeriod{100};

}  // namespace

TaskPublisher::TaskPublisher(bus::Bus& bus, const std::string& worker)
    : worker_(worker),
      tasks_(bus, bus::kTaskStatus),
      kept_tasks_(worker_, intaglio_STAGE_ENGRAVE) {}

void TaskPublisher::Publish(const TaskReport& report, std::chrono::nanoseconds now) {
  const bool changed =
      report.state != published_.state || report.message != published_.message ||
      report.job_uid != published_.job_uid || report.attempt != published_.attempt ||
      report.pause_reason != published_.pause_reason || report.alarm != published_.alarm;
  if (!changed && now < next_task_) return;
  next_task_ = now + kTaskPeriod;
  published_ = report;
  kept_tasks_.Keep(tasks_, published_.job_uid, 0);
  intaglio_TaskStatus sample{};
  sample.job_uid = Borrow(published_.job_uid);
  sample.stage = intaglio_STAGE_ENGRAVE;
  sample.part_count = 1;
  sample.attempt = published_.attempt;
  sample.worker = Borrow(worker_);
  sample.state = published_.state;
  sample.done_count = published_.done_count;
  sample.total_count = published_.total_count;
  sample.elapsed_s = published_.elapsed_s;
  sample.estimate_ticks = published_.estimate_ticks;
  sample.error_code = published_.error_code;
  sample.pause_reason = published_.pause_reason;
  sample.message = Borrow(published_.message);
  sample.counts = published_.counts;
  sample.alarm = Borrow(published_.alarm);
  const std::vector<std::uint8_t> outcome(published_.outcome.begin(),
                                          published_.outcome.end());
  Borrow(sample.outcome, outcome);
  (void)tasks_.Write(sample);
}

}  // namespace intaglio::cell
