// What becomes of the jobs of workers that are lost, fail or are wrong.

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/counted.h"
#include "services/job_service/queue/job_queue.h"

namespace intaglio::job_service {

using namespace std::chrono_literals;

// ---- Workers ------------------------------------------------------------------------

void JobQueue::Receive(const WorkerView& worker, Nanoseconds now) {
  tasks_.workers().Update(worker, now);
  // It ends in order, and its process was asked to.
  if (worker.role == intaglio_ROLE_SYNCHRONIZER &&
      worker.state == intaglio_HEALTH_STOPPING) {
    take_up_.CloseCell(worker.instance, now);
  }
}

void JobQueue::WorkerLost(const std::string& instance, Nanoseconds now) {
  const WorkerBook::Assignments lost = tasks_.workers().Lose(instance, now);
  if (!lost.task.revoked) LoseTasks(instance, lost, instance + " was lost", now);
}

void JobQueue::LoseTasks(const std::string& instance, const WorkerBook::Assignments& has,
                         const std::string& why, Nanoseconds now) {
  discretizing_.LoseAhead(instance, has.next.task);
  LoseTask(instance, has.task.task, why, now);
}

void JobQueue::LoseTask(const std::string& instance, const TaskId& task,
                        const std::string& why, Nanoseconds now) {
  JobRecord* job = book_.FindOpen(task.job_uid);
  if (job == nullptr || job->attempt != task.attempt) return;
  for (const GivenTask& given : job->GivenTasks()) {
    if (given.worker != instance || given.task != task) continue;
    if (host::IsComparison(task.part_attempt)) {
      return discretizing_.comparing().Lose(*job, now);
    }
    if (given.stage == intaglio_STAGE_DISCRETIZE) {
      return LosePart(*job, task.part, why, 0s, now);
    }
    return LoseStage(*job, given.stage, why, now);
  }
}

void JobQueue::LosePart(JobRecord& job, std::uint32_t part, const std::string& why,
                        Nanoseconds pause, Nanoseconds now) {
  const auto given_up = discretizing_.Lose(job, part, why, pause, now);
  if (given_up) EndJob(job, intaglio_JOB_FAILED, *given_up, now);
}

void JobQueue::LoseStage(JobRecord& job, intaglio_Stage stage, const std::string& why,
                         Nanoseconds now) {
  if (job.stage(stage).done || !job.active()) return;
  if (stage != intaglio_STAGE_ENGRAVE || !job.arm.ever_granted()) {
    return LoseAttempt(job, why, now);
  }
  take_up_.Lose(job, why, now);
}

void JobQueue::LoseAttempt(JobRecord& job, const std::string& why, Nanoseconds now) {
  ++job.lost_attempts;
  job.last_loss = fmt::format("attempt {} failed: {}", job.attempt, why);
  if (job.lost_attempts >= kMaxAttempts) {
    return EndJob(job, intaglio_JOB_FAILED,
                  fmt::format("failed after {}; {}",
                              Counted(job.lost_attempts, "attempt"), job.last_loss),
                  now);
  }
  EndAttempt(job, job.last_loss, now);
}

void JobQueue::EndAttempt(JobRecord& job, const std::string& why, Nanoseconds now) {
  Requeue(job, why, now);
  tasks_.RevokeAndStopFeed(job, job.GivenTasks(), now);
  discretizing_.comparing().Drop(job);
}

void JobQueue::Requeue(JobRecord& job, const std::string& why, Nanoseconds now) {
  job.last_loss = why;
  if (job.arm.armed()) {
    job.last_loss += "; it is no longer armed: arm it when it has its machine again";
  }
  job.arm.Disarm(why, now);
  book_.Change(job, intaglio_JOB_QUEUED, job.last_loss);
}

void JobQueue::FeedFailed(const std::string& job_uid, std::uint32_t attempt,
                          const std::string& message, Nanoseconds now) {
  JobRecord* job = book_.FindOpen(job_uid);
  if (job == nullptr || job->attempt != attempt || !job->active()) return;
  EndJob(*job, intaglio_JOB_FAILED, message, now);
}

// ---- Workers that are wrong -----------------------------------------------------------

void JobQueue::RestoreLeftOut(const std::vector<LeftOut>& workers, Nanoseconds now) {
  for (const LeftOut& worker : workers) tasks_.workers().Restore(worker, now);
}

// Nobody knows since when one is wrong: none of its parts is engraved.
void JobQueue::RemakeWrong(Nanoseconds now) {
  for (const WrongWorker& wrong : discretizing_.comparing().TakeWrong()) {
    for (JobRecord* job : JobsOf(wrong.worker)) Remake(*job, wrong, now);
  }
}

std::vector<JobRecord*> JobQueue::JobsOf(const std::string& worker) const {
  std::vector<JobRecord*> jobs = book_.ActiveInTurn();
  std::erase_if(jobs, [&](const JobRecord* job) {
    return std::ranges::find(job->parts, worker, &PartRecord::worker) == job->parts.end();
  });
  return jobs;
}

CommandAnswer JobQueue::Admit(const std::string& worker, const std::string& operator_name,
                              Nanoseconds now) {
  const std::string undecided = discretizing_.comparing().WhyUndecided(worker);
  if (!undecided.empty()) return {intaglio_ANSWER_UNDECIDED, undecided};
  const bool was_suspected =
      !tasks_.workers().WhyLeftOut(worker).empty() && !tasks_.workers().IsWrong(worker);
  if (!tasks_.Admit(worker, operator_name)) {
    return {intaglio_ANSWER_NOT_LEFT_OUT,
            fmt::format("no worker {} is left out: see intaglio workers", worker)};
  }
  // All parts of one that was found wrong were made anew then; what is begun goes on.
  if (!was_suspected) return {};
  const std::string why = fmt::format("{} was suspected, and {} has admitted it again",
                                      worker, operator_name);
  for (JobRecord* job : JobsOf(worker)) {
    if (!job->arm.ever_granted()) Remake(*job, {worker, why}, now);
  }
  return {};
}

void JobQueue::Remake(JobRecord& job, const WrongWorker& wrong, Nanoseconds now) {
  if (!job.arm.ever_granted()) {
    job.last_loss = fmt::format("attempt {} is made anew: {}", job.attempt, wrong.why);
    return EndAttempt(job, job.last_loss, now);
  }
  const std::string why = fmt::format(
      "{}; it made points of this job: compare the piece with its model, then "
      "resume the job or cancel it",
      wrong.why);
  job.warnings.push_back({WarningCode::kUntrustedPoints, WarningWeight::kWarning, why});
  job.arm.Disarm(why, now);
  book_.ChangeToPaused(job, intaglio_PAUSE_FAULT, why);
}

}  // namespace intaglio::job_service
