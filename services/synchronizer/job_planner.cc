#include "services/synchronizer/job_planner.h"

#include <utility>

namespace intaglio::synchronizer {
namespace {

// The loop turns every 5 ms and asks.
const auto kNoWake = [] {};

template <typename Computations>
void EraseReady(Computations& computations) {
  std::erase_if(computations, [](const auto& one) { return one->ready(); });
}

template <typename Computation>
void Retire(std::unique_ptr<Computation>& one,
            std::vector<std::unique_ptr<Computation>>& abandoned) {
  if (one == nullptr) return;
  one->Cancel();
  abandoned.push_back(std::move(one));
}

}  // namespace

void JobPlanner::Begin(PreparationTask task) {
  Abandon();
  waiting_ = std::move(task);
}

void JobPlanner::Abandon() {
  waiting_.reset();
  Retire(preparation_, abandoned_preparations_);
  Retire(summary_, abandoned_summaries_);
  summarized_.reset();
  DropEnded();
}

void JobPlanner::DropEnded() {
  EraseReady(abandoned_preparations_);
  EraseReady(abandoned_summaries_);
}

std::optional<Result<PreparedJob>> JobPlanner::TakePrepared() {
  DropEnded();
  if (waiting_ && abandoned_preparations_.empty()) {
    preparation_ = std::make_unique<Preparation>(
        [task = std::move(*waiting_)](const ProgressSink& progress) mutable {
          return PrepareJob(std::move(task), progress);
        },
        kNoWake);
    waiting_.reset();
  }
  if (preparation_ == nullptr || !preparation_->ready()) return std::nullopt;
  auto prepared = preparation_->Take();
  preparation_.reset();
  if (prepared) {
    summary_ = std::make_unique<Summary>(
        [job = std::move(prepared->job),
         plan = std::move(prepared->plan)](const ProgressSink& progress) mutable {
          return Summarize(job, std::move(plan), progress);
        },
        kNoWake);
  }
  return prepared;
}

const Result<PlanSummary>* JobPlanner::summary() {
  DropEnded();
  if (summary_ != nullptr && summary_->ready()) {
    summarized_ = summary_->Take();
    summary_.reset();
  }
  return summarized_ ? &*summarized_ : nullptr;
}

}  // namespace intaglio::synchronizer
