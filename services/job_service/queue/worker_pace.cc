#include "services/job_service/queue/worker_pace.h"

#include <algorithm>
#include <vector>

namespace intaglio::job_service {
namespace {

/// The lower one of two. `values` is not empty.
double MedianOf(std::vector<double> values) {
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<double> WorkerPace::RatioOf(const Done& done) const {
  std::vector<double> elapsed_s, per_point_s;
  for (const Done& other : done_) {
    const bool counts = !other.first && other.worker != done.worker &&
                        other.job_uid == done.job_uid && other.attempt == done.attempt;
    if (!counts) continue;
    elapsed_s.push_back(other.elapsed_s);
    per_point_s.push_back(other.per_point_s);
  }
  if (elapsed_s.size() < kMinOtherParts) return std::nullopt;
  const double part_s = std::max(MedianOf(elapsed_s), 1e-9);
  const double point_s = std::max(MedianOf(per_point_s), 1e-12);
  return std::min(done.elapsed_s / part_s, done.per_point_s / point_s);
}

std::optional<double> WorkerPace::NoteDone(const std::string& worker, const TaskId& task,
                                           double elapsed_s, std::uint64_t point_count) {
  Done done{worker, task.job_uid, task.attempt, elapsed_s,
            elapsed_s / static_cast<double>(std::max<std::uint64_t>(1, point_count))};
  done.first = std::ranges::none_of(done_, [&](const Done& other) {
    return other.worker == worker && other.job_uid == task.job_uid &&
           other.attempt == task.attempt;
  });
  const auto ratio = done.first ? std::nullopt : RatioOf(done);
  done_.push_back(std::move(done));
  if (done_.size() > kKept) done_.pop_front();
  std::erase_if(slow_, [this](const auto& entry) {
    return std::ranges::find(done_, entry.first, &Done::worker) == done_.end();
  });
  if (!ratio) return std::nullopt;
  if (*ratio <= kSlowRatio || elapsed_s < kMinSlow_s) {
    slow_.erase(worker);
    return std::nullopt;
  }
  std::vector<double>& in_a_row = slow_[worker];
  in_a_row.push_back(*ratio);
  if (in_a_row.size() < kSlowParts) return std::nullopt;
  const double slower = MedianOf(in_a_row);
  slow_.erase(worker);
  return slower;
}

}  // namespace intaglio::job_service
