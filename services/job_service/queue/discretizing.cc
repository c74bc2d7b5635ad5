#include "services/job_service/queue/discretizing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "engrave/core/counted.h"
#include "proto/task.pb.h"
#include "services/job/fields/job_kind.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {
namespace {

// Marks are made at once: their order is the job's, and no mark may be made twice.
bool MakesMarksWhole(const JobRecord& job) {
  FrozenJob frozen;
  return frozen.ParseFromString(job.frozen_job) && MakesMarks(frozen.job());
}

}  // namespace

void Discretizing::Cut(JobRecord& job, const std::vector<std::string>& discretizers,
                       Nanoseconds now) {
  job.parts.Cut(MakesMarksWhole(job) ? 1 : discretizers.size(), now);
  const std::size_t count = std::min(discretizers.size(), job.parts.size());
  for (std::uint32_t i = 0; i < count; ++i) job.parts.Give(i, discretizers[i]);
}

void Discretizing::GiveFirst(const JobRecord& job, Nanoseconds now) {
  for (std::uint32_t part = 0; part < job.parts.size(); ++part) {
    if (!job.parts[part].worker.empty()) tasks_.GivePart(job, part, now);
  }
}

void Discretizing::GiveOpen(JobRecord& job, Nanoseconds now) {
  comparing_.Give(job, now);
  if (!job.active() || job.stage(intaglio_STAGE_DISCRETIZE).done) return;
  for (const std::string& worker :
       tasks_.workers().Free(intaglio_ROLE_DISCRETIZER, job.cell)) {
    const auto part = job.parts.NextOpen(now);
    if (!part) break;
    job.parts.Give(*part, worker);
    tasks_.GivePart(job, *part, now);
  }
  GiveAhead(job, now);
  PublishMessage(job);
}

void Discretizing::GiveAhead(JobRecord& job, Nanoseconds now) {
  for (const std::string& worker :
       tasks_.workers().WithoutNext(intaglio_ROLE_DISCRETIZER, job.uid, job.attempt)) {
    const auto part = job.parts.NextAhead();
    if (!part) return;
    job.parts.Give(*part, worker);
    tasks_.GivePartAhead(job, *part, now);
  }
}

void Discretizing::PublishMessage(JobRecord& job) {
  if (job.state != intaglio_JOB_DISCRETIZING) return;
  std::vector<std::string> sentences;
  if (!job.arm_loss.empty()) sentences.push_back(job.arm_loss);
  if (!job.last_loss.empty()) {
    sentences.push_back(fmt::format("attempt {}: {}", job.attempt, job.last_loss));
  }
  if (!job.parts.last_loss().empty()) sentences.push_back(job.parts.last_loss());
  if (!job.suspicion.empty()) sentences.push_back(job.suspicion);
  const WorkerBook& workers = tasks_.workers();
  if (!job.parts.any_at_work() && job.suspicion.empty() &&
      workers.Free(intaglio_ROLE_DISCRETIZER, job.cell).empty()) {
    sentences.push_back("waits for " + workers.WhyNone(intaglio_ROLE_DISCRETIZER,
                                                       job.cell, job.maker(), true));
  }
  const std::string message = fmt::format("{}", fmt::join(sentences, "; "));
  if (message != job.message) book_.Publish(job, job.state, message);
}

void Discretizing::SetProgress(JobRecord& job, Nanoseconds now) {
  const JobParts::Progress progress = job.parts.ProgressAt(now);
  StageRecord& stage = job.stage(intaglio_STAGE_DISCRETIZE);
  stage.done_count = progress.done_count;
  stage.total_count = progress.total_count;
  stage.elapsed_s = progress.elapsed_s;
}

Discretizing::Outcome Discretizing::Receive(JobRecord& job, const TaskView& task,
                                            Nanoseconds now) {
  const std::uint32_t part = task.task.part;
  if (host::IsComparison(task.task.part_attempt)) {
    comparing_.Receive(job, task, now);
    return Outcome::kIgnored;
  }
  if (!job.parts.IsCurrent(task.worker, part, task.task.part_attempt)) {
    return Outcome::kIgnored;
  }
  job.parts.SetProgress(part, task.done_count, task.total_count);
  if (task.state == intaglio_TASK_FAILED) return Outcome::kFailed;
  if (task.state == intaglio_TASK_DONE) {
    job.parts.Finish(part);
    NotePace(task, now);
    comparing_.NoteDone(job, part, task.checksum);
  }
  SetProgress(job, now);
  if (job.parts.all_done()) {
    if (!job.comparison) tasks_.StopFeed(job);
    return Outcome::kAllDone;
  }
  book_.PublishProgress(job);
  return Outcome::kProgress;
}

void Discretizing::NotePace(const TaskView& task, Nanoseconds now) {
  const auto slower =
      pace_.NoteDone(task.worker, task.task, task.elapsed_s, task.done_count);
  if (!slower) return;
  tasks_.workers().SetSlow(
      task.worker,
      fmt::format(
          "{} takes {:.0f} times as long for a part as the others: it is given "
          "nothing for {} min while others run; check what else its computer does",
          task.worker, *slower, kSlowFor.count()),
      now + kSlowFor);
}

std::optional<std::string> Discretizing::Lose(JobRecord& job, std::uint32_t part,
                                              const std::string& why, Nanoseconds pause,
                                              Nanoseconds now) {
  const PartRecord& record = job.parts.at(part);
  if (record.done || !job.active()) return std::nullopt;
  const GivenTask given{record.worker, intaglio_STAGE_DISCRETIZE,
                        job.TaskOf(intaglio_STAGE_DISCRETIZE, part), false};
  tasks_.RevokeHeld(job, {given}, now);
  const std::uint32_t losses = record.losses + 1;
  if (losses >= host::kMaxPartLosses) {
    return fmt::format("{} has failed after {}; {}", job.parts.NameOf(part),
                       Counted(losses, "attempt"), why);
  }
  job.parts.Lose(part, why, now + pause);
  SetProgress(job, now);
  PublishMessage(job);
  return std::nullopt;
}

void Discretizing::LoseAhead(const std::string& worker, const TaskId& task) {
  JobRecord* job = book_.FindOpen(task.job_uid);
  if (job == nullptr || job->attempt != task.attempt || !job->active()) return;
  if (!job->parts.IsCurrent(worker, task.part, task.part_attempt)) return;
  tasks_.RevokePartAhead(*job, worker, task);
  job->parts.LoseAhead(task.part);
}

}  // namespace intaglio::job_service
