#include "services/job_service/queue/comparing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// As long as a part that failed for want of its neighbour waits (job_queue).
constexpr Nanoseconds kPause = 2s;

constexpr const char* kDecides =
    ": start another discretizer, which decides, or restart one of them";

std::string NamesOf(const PartComparison& comparison) {
  std::vector<std::string> names;
  for (const PartComparison::Made& made : comparison.made) names.push_back(made.worker);
  return fmt::format("{}", fmt::join(names, " and "));
}

bool HasMade(const PartComparison& comparison, const std::string& worker) {
  return std::ranges::find(comparison.made, worker, &PartComparison::Made::worker) !=
         comparison.made.end();
}

/// A checksum that two have made; nullptr: all differ.
const std::string* RightOf(const PartComparison& comparison) {
  for (const PartComparison::Made& made : comparison.made) {
    if (std::ranges::count(comparison.made, made.checksum,
                           &PartComparison::Made::checksum) > 1) {
      return &made.checksum;
    }
  }
  return nullptr;
}

std::string Difference(const JobRecord& job, const PartComparison& comparison) {
  return fmt::format("{} of job {} was made differently by {}, and one of them is wrong",
                     job.parts.NameOf(comparison.part), job.number, NamesOf(comparison));
}

/// Nobody decides any more.
std::string RestartAll(const JobRecord& job, const PartComparison& comparison) {
  return Difference(job, comparison) + ": restart all of them";
}

}  // namespace

void Comparing::NoteDone(JobRecord& job, std::uint32_t part,
                         const std::string& checksum) {
  if (++done_count_ < kCompareEvery || job.comparison) return;
  PartComparison comparison;
  comparison.part = part;
  comparison.made.push_back({job.parts[part].worker, checksum});
  if (Candidates(comparison).empty()) return;
  job.comparison = std::move(comparison);
  done_count_ = 0;
}

std::vector<std::string> Comparing::Candidates(const PartComparison& comparison) const {
  auto serving = tasks_.workers().Serving(intaglio_ROLE_DISCRETIZER);
  std::erase_if(serving,
                [&](const std::string& worker) { return HasMade(comparison, worker); });
  return serving;
}

void Comparing::Give(JobRecord& job, Nanoseconds now) {
  if (!job.comparison || !job.active()) return;
  PartComparison& comparison = *job.comparison;
  WorkerBook& workers = tasks_.workers();
  if (comparison.at_work()) {
    if (workers.IsAlive(comparison.worker) &&
        workers.IsAssigned(comparison.worker, job.ComparisonTask())) {
      return;
    }
    Reopen(job, now);  // revoked with another task of its chain
  }
  ForgetWrong(job);
  const auto candidates = Candidates(comparison);
  const bool may_be_made =
      !candidates.empty() && comparison.times < host::kMaxComparisons;
  if (!may_be_made) return comparison.made.size() > 1 ? Suspect(job) : Settle(job);
  if (now < comparison.not_before) return;
  const auto give = [&](const std::vector<std::string>& idle, bool ahead) {
    const auto found = std::ranges::find_first_of(candidates, idle);
    if (found == candidates.end()) return false;
    GiveTo(job, *found, ahead, now);
    return true;
  };
  if (give(workers.Free(intaglio_ROLE_DISCRETIZER, job.cell), false)) return;
  give(workers.WithoutNext(intaglio_ROLE_DISCRETIZER, job.uid, job.attempt), true);
}

// What they made proves nothing. If it is the first, the job begins anew.
void Comparing::ForgetWrong(JobRecord& job) {
  PartComparison& comparison = *job.comparison;
  const std::string maker = comparison.made.front().worker;
  const auto forgotten =
      std::erase_if(comparison.made, [&](const PartComparison::Made& made) {
        return made.worker != maker && tasks_.workers().IsWrong(made.worker);
      });
  if (forgotten == 0 || comparison.made.size() > 1) return;
  comparison.suspected_count = 0;
  TakeBack(job, maker);
}

void Comparing::GiveTo(JobRecord& job, const std::string& worker, bool ahead,
                       Nanoseconds now) {
  job.comparison->worker = worker;
  ++job.comparison->times;
  tasks_.GiveComparison(job, ahead, now);
}

void Comparing::Reopen(JobRecord& job, Nanoseconds not_before) {
  job.comparison->worker.clear();
  job.comparison->not_before = not_before;
}

void Comparing::Lose(JobRecord& job, Nanoseconds now) {
  if (!job.comparison || !job.comparison->at_work()) return;
  tasks_.RevokeHeld(
      job,
      {{job.comparison->worker, intaglio_STAGE_DISCRETIZE, job.ComparisonTask(), false}},
      now);
  Reopen(job, now);
}

void Comparing::Receive(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (!job.comparison || !job.comparison->at_work() || !task.ended()) return;
  PartComparison& comparison = *job.comparison;
  if (task.worker != comparison.worker || task.task != job.ComparisonTask()) return;
  if (task.state == intaglio_TASK_FAILED && task.failed_by_neighbour()) {
    return Reopen(job, now + kPause);
  }
  comparison.made.push_back({task.worker, task.state == intaglio_TASK_DONE
                                              ? task.checksum
                                              : "failed: " + task.message});
  comparison.worker.clear();
  Decide(job);
}

void Comparing::Decide(JobRecord& job) {
  const PartComparison& comparison = *job.comparison;
  const std::string* right = RightOf(comparison);
  if (right == nullptr) return;
  std::vector<std::string> equal;
  for (const PartComparison::Made& made : comparison.made) {
    if (made.checksum != *right) continue;
    equal.push_back(made.worker);
  }
  std::ranges::sort(equal);
  for (const PartComparison::Made& made : comparison.made) {
    if (made.checksum == *right) continue;
    wrong_.push_back(
        {made.worker,
         fmt::format("{} made {} of job {} wrong, other than {}: it is given nothing "
                     "more until it is restarted or admitted again (intaglio workers "
                     "admit {}); check its computer",
                     made.worker, job.parts.NameOf(comparison.part), job.number,
                     fmt::join(equal, " and "), made.worker)});
    tasks_.LeaveOut(made.worker, wrong_.back().why);
  }
  for (const std::string& worker : equal) TakeBack(job, worker);
  Settle(job);
}

void Comparing::Suspect(JobRecord& job) {
  PartComparison& comparison = *job.comparison;
  if (comparison.suspected_count == comparison.made.size()) return;
  comparison.suspected_count = comparison.made.size();
  const std::string why = Difference(job, comparison) + kDecides;
  for (const PartComparison::Made& made : comparison.made) {
    tasks_.Suspect(made.worker, why, RestartAll(job, comparison));
  }
}

// Nobody decides any more which of them is right, unless all but one were found wrong.
void Comparing::Drop(JobRecord& job) {
  if (!job.comparison) return;
  const std::string why = RestartAll(job, *job.comparison);
  std::vector<PartComparison::Made> made = std::move(job.comparison->made);
  job.comparison.reset();
  const bool differ = made.size() > 1;
  std::erase_if(made, [this](const PartComparison::Made& one) {
    return tasks_.workers().IsWrong(one.worker);
  });
  if (differ && made.size() == 1) return TakeBack(job, made.front().worker);
  for (const PartComparison::Made& one : made) {
    if (made.size() > 1) tasks_.Suspect(one.worker, why, why);
  }
}

std::string Comparing::WhyUndecided(const std::string& worker) const {
  for (const JobRecord* job : book_.ActiveInTurn()) {
    if (job->comparison && IsUndecided(*job->comparison, worker))
      return Difference(*job, *job->comparison) + kDecides;
  }
  return "";
}

bool Comparing::IsUndecided(const PartComparison& comparison,
                            const std::string& worker) const {
  const auto trusted =
      std::ranges::count_if(comparison.made, [this](const PartComparison::Made& made) {
        return !tasks_.workers().IsWrong(made.worker);
      });
  return trusted > 1 && HasMade(comparison, worker) && !tasks_.workers().IsWrong(worker);
}

// Who is suspected for another job as well stays so until that is decided.
void Comparing::TakeBack(const JobRecord& decided, const std::string& worker) {
  for (const JobRecord* job : book_.ActiveInTurn()) {
    if (job != &decided && job->comparison && IsUndecided(*job->comparison, worker))
      return;
  }
  tasks_.TakeBack(worker);
}

void Comparing::Settle(JobRecord& job) {
  job.comparison.reset();
  if (job.stage(intaglio_STAGE_DISCRETIZE).done) tasks_.StopFeed(job);
}

void Comparing::Hold(JobRecord& job, Nanoseconds now) {
  if (job.arm.ever_granted()) return;
  std::string suspicion;
  for (const PartRecord& part : job.parts) {
    suspicion = tasks_.workers().WhyLeftOut(part.worker);
    if (!suspicion.empty()) break;
  }
  if (suspicion == job.suspicion) return;
  job.suspicion = suspicion;
  if (suspicion.empty()) {
    // The machine's next report has the message of a job whose path is there.
    if (job.state != intaglio_JOB_DISCRETIZING) book_.Publish(job, job.state, "");
    return;
  }
  if (job.arm.armed()) job.arm.Disarm(suspicion, now);
  book_.Change(job, job.state, suspicion);
}

}  // namespace intaglio::job_service
