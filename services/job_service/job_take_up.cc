#include <fmt/format.h>

#include <algorithm>

#include "services/job_service/job_queue.h"
#include "services/platform/host/absence_limit.h"

// The part of the queue that has to do with an engraving whose synchronizer, or whose
// line, was lost: the block is still in the machine, and the journal knows what is in it.
//
// The operator's arm stands for the machine as it was left, and nothing that a person has
// to look at has happened: so the job goes on by itself. Not after a fault or an opened
// interlock, which the synchronizer tells apart; not when it was not armed; not when the
// synchronizer, or this job service, was away for longer than host::kMaxAbsence, for the
// block may have been changed; not when a person closed the shop or the cell; and not
// when kMaxRenewals in a row made no point, for then somebody is needed.

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// With the longest wait between them, a minute.
constexpr std::uint32_t kMaxRenewals = 20;
constexpr Nanoseconds kFirstWait = 300ms;
constexpr Nanoseconds kLongestWait = 3s;

}  // namespace

void JobQueue::GoOn(JobRecord& job, Nanoseconds now) {
  if (job.asks_before_resume || stopped_cells_.contains(job.cell)) return;
  const std::uint64_t done = job.stage(intaglio_STAGE_ENGRAVE).done_count;
  if (done != job.done_at_loss) job.losses = 0;
  job.done_at_loss = done;
  if (job.losses >= kMaxRenewals) return;
  const Nanoseconds wait =
      std::min(kLongestWait, kFirstWait * (1 << std::min(job.losses, 8u)));
  ++job.losses;
  job.armed = true;
  job.armed_at = now + wait;
  // Greater than before, also over a restart.
  job.renewal = job.revision + 1;
}

void JobQueue::LoseEngraving(JobRecord& job, const std::string& why, Nanoseconds now) {
  const bool was_armed = job.armed;
  Disarm(job, why, now);
  if (was_armed) GoOn(job, now);
  if (!job.absent_since) job.absent_since = now;
  // What is kept names no worker: a word of the lost one, heard after a restart, is not
  // about this job any more.
  const std::vector<GivenTask> given = job.GivenTasks();
  job.stage(intaglio_STAGE_ENGRAVE).worker.clear();
  ChangeToPaused(
      job, intaglio_PAUSE_SYNCHRONIZER_LOST,
      fmt::format("{}: the next synchronizer of {} takes the job up where the journal "
                  "ends{}",
                  why, job.cell, job.armed ? "" : "; then resume it"));
  Revoke(job, given, now);
}

void JobQueue::TakeUp(JobRecord& job, Nanoseconds now) {
  if (job.state != intaglio_JOB_PAUSED || !job.ever_granted) return;
  StageRecord& stage = job.stage(intaglio_STAGE_ENGRAVE);
  if (workers_.IsAlive(stage.worker)) return;
  const auto free = workers_.Free(intaglio_ROLE_SYNCHRONIZER, job.cell);
  if (free.empty()) return;
  stage.worker = free.front();
  job.taken_up = true;
  Change(job, job.state,
         job.armed ? fmt::format("{} takes the job up", stage.worker)
                   : fmt::format("{} takes the job up; resume it if the block was not "
                                 "touched, or cancel it",
                                 stage.worker));
  workers_.Assign(stage.worker, job.TaskOf(intaglio_STAGE_ENGRAVE), now);
  actions_.Give({.worker = stage.worker,
                 .stage = intaglio_STAGE_ENGRAVE,
                 .task = job.TaskOf(intaglio_STAGE_ENGRAVE),
                 .consumer = {},
                 .take_up = true},
                job);
}

void JobQueue::EndAbsences(Nanoseconds now) {
  const bool paused = last_turn_ && now - *last_turn_ > host::kMaxAbsence;
  last_turn_ = now;
  EndArms(intaglio_PAUSE_ABSENCE, now, [&](const JobRecord& job) -> std::string {
    const bool absent = job.absent_since && now - *job.absent_since > host::kMaxAbsence;
    if (!paused && !absent) return {};
    return fmt::format("{} was away for more than {} s",
                       absent ? "the synchronizer of " + job.cell : "the job service",
                       host::kMaxAbsence.count());
  });
}

void JobQueue::Close(Nanoseconds now) {
  EndArms(intaglio_PAUSE_CLOSED, now,
          [](const JobRecord&) { return std::string("the shop was closed"); });
}

void JobQueue::CloseCell(const std::string& synchronizer, Nanoseconds now) {
  EndArms(intaglio_PAUSE_CLOSED, now, [&](const JobRecord& job) {
    return job.stage(intaglio_STAGE_ENGRAVE).worker == synchronizer
               ? fmt::format("the synchronizer of {} was closed", job.cell)
               : std::string();
  });
}

void JobQueue::EndArms(intaglio_PauseReason reason, Nanoseconds now,
                       const WhyItEnds& why) {
  for (auto& [uid, job] : jobs_) {
    if (job.ended() || !job.armed) continue;
    const std::string text = why(job);
    if (!text.empty()) EndArm(job, reason, text, now);
  }
}

void JobQueue::EndArm(JobRecord& job, intaglio_PauseReason reason, const std::string& why,
                      Nanoseconds now) {
  Disarm(job, why, now);
  const std::string message =
      fmt::format("{}: see that the right block is in the machine, then {} the job", why,
                  job.ever_granted ? "resume" : "arm");
  const bool pauses =
      job.state == intaglio_JOB_ENGRAVING || job.state == intaglio_JOB_PAUSED;
  if (pauses) return ChangeToPaused(job, reason, message);
  Change(job, job.state, message);
}

// Topics overtake each other after a network was away: a synchronizer may say that it is
// ready, and get the job again, before its word on the revocation arrives.
bool JobQueue::AnswersAnOldRevocation(const TaskView& task) const {
  const JobRecord* job = Find(task.task.job_uid);
  return task.stage == intaglio_STAGE_ENGRAVE && task.state == intaglio_TASK_FAILED &&
         task.error_code == intaglio_ERROR_CANCELLED && job != nullptr && job->taken_up &&
         workers_.IsAssigned(task.worker, task.task);
}

}  // namespace intaglio::job_service
