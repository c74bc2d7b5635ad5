#include "services/job_service/queue/take_up.h"

#include <fmt/format.h>

#include <vector>

namespace intaglio::job_service {
namespace {

// Turns come some 20 ms apart; a longer time without one is an absence of this process.
constexpr Nanoseconds kLongTurn = std::chrono::seconds(1);

}  // namespace

void TakeUp::Restore(JobRecord& job, bool arm_counts, Nanoseconds now) {
  const bool waited = job.state == intaglio_JOB_PAUSED && !job.arm.armed();
  job.arm.Drop();
  const std::string& synchronizer = job.stage(intaglio_STAGE_ENGRAVE).worker;
  if (!synchronizer.empty()) {
    WorkerBook& workers = tasks_.workers();
    workers.Assign(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE), now);
    workers.Answered(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE));
  }
  if (arm_counts) arming_.Renew(job, now);
  // A job that waits for a person keeps its reason.
  if (waited) return book_.Change(job, intaglio_JOB_PAUSED, job.message);
  if (!job.arm.armed()) job.arm.Disarm("the job service was restarted", now);
  book_.ChangeToPaused(
      job, intaglio_PAUSE_RESTART,
      job.arm.armed() ? "the job service was restarted; the job continues automatically"
                      : "the job service was restarted while this job was being "
                        "engraved; resume it if the block was not touched, or cancel it");
}

void TakeUp::Lose(JobRecord& job, const std::string& why, Nanoseconds now) {
  const bool was_armed = job.arm.armed();
  job.arm.Disarm(why, now);
  if (was_armed) arming_.Renew(job, now);
  job.arm.BeginAbsence(now);
  // The stored job names no worker: a report of the lost one that is received after a
  // restart is not about this job any more.
  const std::vector<GivenTask> given = job.GivenTasks();
  job.stage(intaglio_STAGE_ENGRAVE).worker.clear();
  book_.ChangeToPaused(
      job, intaglio_PAUSE_SYNCHRONIZER_LOST,
      fmt::format("{}: the next {} of {} continues the job where the journal ends{}", why,
                  job.maker(), job.cell, job.arm.armed() ? "" : "; then resume it"));
  tasks_.RevokeAndStopFeed(job, given, now);
}

void TakeUp::GiveToFree(JobRecord& job, Nanoseconds now) {
  if (job.state != intaglio_JOB_PAUSED || !job.arm.ever_granted()) return;
  StageRecord& stage = job.stage(intaglio_STAGE_ENGRAVE);
  if (tasks_.workers().IsAlive(stage.worker)) return;
  const auto free = tasks_.workers().Free(intaglio_ROLE_SYNCHRONIZER, job.cell);
  if (free.empty()) return;
  stage.worker = free.front();
  job.taken_up = true;
  book_.Change(job, job.state,
               job.arm.armed()
                   ? fmt::format("{} continues the job", stage.worker)
                   : fmt::format("{} continues the job after a resume: resume it if the "
                                 "block was not touched, or cancel it",
                                 stage.worker));
  tasks_.GiveTakeUp(job, now);
}

// This process itself was stopped, or the computer was too busy for it.
bool TakeUp::WasPausedForTooLong(Nanoseconds now) {
  bool too_long = false;
  if (last_turn_ && now - *last_turn_ > kLongTurn) {
    own_absence_.Begin(*last_turn_);
    too_long = own_absence_.IsTooLong(now);
    own_absence_.End(now);
  }
  last_turn_ = now;
  return too_long;
}

void TakeUp::EndAbsences(Nanoseconds now) {
  const bool paused = WasPausedForTooLong(now);
  arming_.EndArms(intaglio_PAUSE_ABSENCE, now, [&](const JobRecord& job) -> std::string {
    const bool absent = job.arm.IsAbsentForTooLong(now);
    if (!paused && !absent) return {};
    return fmt::format("{} was absent for more than {} s",
                       absent ? "the synchronizer of " + job.cell : "the job service",
                       host::kMaxAbsence.count());
  });
}

void TakeUp::CloseShop(Nanoseconds now) {
  arming_.EndArms(intaglio_PAUSE_CLOSED, now,
                  [](const JobRecord&) { return std::string("the shop was closed"); });
}

void TakeUp::CloseCell(const std::string& synchronizer, Nanoseconds now) {
  arming_.EndArms(intaglio_PAUSE_CLOSED, now, [&](const JobRecord& job) {
    return job.stage(intaglio_STAGE_ENGRAVE).worker == synchronizer
               ? fmt::format("the synchronizer of {} was closed", job.cell)
               : std::string();
  });
}

bool TakeUp::AnswersAnOldRevocation(const TaskView& task) const {
  const JobRecord* job = book_.Find(task.task.job_uid);
  return task.stage == intaglio_STAGE_ENGRAVE && task.state == intaglio_TASK_FAILED &&
         task.error_code == intaglio_ERROR_CANCELLED && job != nullptr && job->taken_up &&
         tasks_.workers().IsAssigned(task.worker, task.task);
}

}  // namespace intaglio::job_service
