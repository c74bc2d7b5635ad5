#include "services/client/shop/queue_time.h"

#include <algorithm>

#include "services/client/shop/work_left.h"

namespace intaglio::client {
namespace {

// A longer time, as of a damaged queue, would overflow the clock.
constexpr double kLongestS = 1e8;

double EngravedShare(const JobView& job) {
  const JobView::Progress* stage = StageAtWork(job);
  if (stage == nullptr || stage->stage != intaglio_STAGE_ENGRAVE ||
      stage->total_count == 0)
    return 0;
  return std::min(1.0, static_cast<double>(stage->done_count) /
                           static_cast<double>(stage->total_count));
}

}  // namespace

double MachineSecondsLeft(const JobView& job) {
  const double share = EngravedShare(job);
  const double by_pace = share > 0 ? WorkLeftOf(job).left_s : 0;
  return by_pace > 0 ? by_pace : (1 - share) * EngravingSeconds(job);
}

std::vector<QueueTime> QueueTimesOf(const std::vector<JobView>& jobs,
                                    std::chrono::system_clock::time_point now) {
  std::map<std::string, QueueTime> queues;
  for (const JobView& job : jobs) {
    if (job.ended()) continue;
    QueueTime& queue = queues[job.cell];
    const double left_s = MachineSecondsLeft(job);
    queue.set_jobs(queue.jobs() + 1);
    if (left_s > 0)
      queue.set_left_s(std::min(queue.left_s() + left_s, kLongestS));
    else
      queue.set_unknown_jobs(queue.unknown_jobs() + 1);
  }
  std::vector<QueueTime> times;
  for (auto& [cell, queue] : queues) {
    queue.set_cell(cell);
    if (queue.left_s() > 0) queue.set_ends_utc(EndUtc(now, queue.left_s()));
    times.push_back(std::move(queue));
  }
  return times;
}

}  // namespace intaglio::client
