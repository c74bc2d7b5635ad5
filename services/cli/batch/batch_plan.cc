#include "services/cli/batch/batch_plan.h"

#include <algorithm>
#include <numeric>

namespace intaglio::cli {

BatchPlan::BatchPlan(std::vector<PlannedJob> jobs, std::size_t parallel)
    : jobs_(std::move(jobs)),
      states_(jobs_.size(), State::kWaiting),
      order_(jobs_.size()) {
  for (const PlannedJob& job : jobs_) {
    for (const std::string& cell : job.cells) out_[cell] = 0;
  }
  const std::size_t cells = std::max<std::size_t>(out_.size(), 1);
  parallel_ = parallel == 0 ? cells : parallel;
  share_ = (parallel_ + cells - 1) / cells;
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    return jobs_[a].priority > jobs_[b].priority;
  });
}

bool BatchPlan::MayBegin(std::size_t job) const {
  const auto& after = jobs_[job].after;
  return states_[job] == State::kWaiting &&
         std::all_of(after.begin(), after.end(), [this](std::size_t before) {
           return states_[before] == State::kGood;
         });
}

const std::string* BatchPlan::FreeCell(std::size_t job) const {
  const std::string* best = nullptr;
  for (const std::string& cell : jobs_[job].cells) {
    if (out_.at(cell) >= share_) continue;
    if (best == nullptr || out_.at(cell) < out_.at(*best)) best = &cell;
  }
  return best;
}

std::vector<BatchPlan::Start> BatchPlan::Next() {
  std::vector<Start> starts;
  for (const std::size_t job : order_) {
    if (stopped_ || count(State::kOut) >= parallel_) break;
    if (!MayBegin(job)) continue;
    const std::string* cell = FreeCell(job);
    if (cell == nullptr) continue;
    states_[job] = State::kOut;
    cell_of_[job] = *cell;
    ++out_[*cell];
    starts.push_back({job, *cell});
  }
  return starts;
}

std::vector<std::size_t> BatchPlan::Ended(std::size_t job, bool good) {
  states_.at(job) = good ? State::kGood : State::kBad;
  --out_.at(cell_of_.at(job));
  std::vector<std::size_t> skipped;
  if (good) return skipped;
  // What comes after a skipped one is skipped as well.
  for (bool found = true; found;) {
    found = false;
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      if (states_[i] != State::kWaiting) continue;
      const auto& after = jobs_[i].after;
      const bool lost = std::any_of(after.begin(), after.end(), [this](std::size_t b) {
        return states_[b] == State::kBad || states_[b] == State::kSkipped;
      });
      if (!lost) continue;
      states_[i] = State::kSkipped;
      skipped.push_back(i);
      found = true;
    }
  }
  return skipped;
}

std::size_t BatchPlan::count(State state) const {
  return static_cast<std::size_t>(std::count(states_.begin(), states_.end(), state));
}

bool BatchPlan::over() const {
  return count(State::kOut) == 0 && (stopped_ || count(State::kWaiting) == 0);
}

}  // namespace intaglio::cli
