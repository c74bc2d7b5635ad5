#include "services/job_service/job_queue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "services/platform/host/absence_limit.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// A worker's loop turns many times a second, and its health comes five times: one that is
// silent so long never got its task, or hangs.
constexpr Nanoseconds kAnswerWithin = 10s;

// A part that failed for want of its neighbour waits until a dead sorter, which may be
// the reason, is missed (its lease is 1.5 s): that costs the attempt, and not the part's
// tries.
constexpr Nanoseconds kPartPause = 2s;

constexpr intaglio_ServiceRole RoleOf(intaglio_Stage stage) {
  switch (stage) {
    case intaglio_STAGE_DISCRETIZE:
      return intaglio_ROLE_DISCRETIZER;
    case intaglio_STAGE_SORT:
      return intaglio_ROLE_SORTER;
    case intaglio_STAGE_ENGRAVE:
      break;
  }
  return intaglio_ROLE_SYNCHRONIZER;
}

/// Higher priorities first; of equal ones in the order of submission.
std::pair<std::int32_t, std::uint32_t> TurnOf(const JobRecord& job) {
  return {-job.priority, job.number};
}

// Failures that a neighbour's death causes as well: worth another attempt.
bool MayBeANeighbours(intaglio_ErrorCode code) {
  return code == intaglio_ERROR_LINK_LOST || code == intaglio_ERROR_TIMED_OUT ||
         code == intaglio_ERROR_CANCELLED;
}

}  // namespace

// ---- Jobs ---------------------------------------------------------------------------

void JobQueue::Restore(std::vector<JobRecord> jobs, std::optional<Nanoseconds> absence,
                       Nanoseconds now) {
  const bool was_short = absence && *absence <= host::kMaxAbsence;
  for (JobRecord& restored : jobs) {
    JobRecord& job = jobs_[restored.uid] = std::move(restored);
    if (job.ended()) {
      ended_.Add(job.uid, now);
      actions_.Progressed(job);
      continue;
    }
    in_turn_[TurnOf(job)] = job.uid;
    const bool arm_stands = job.armed && was_short && !job.asks_before_resume;
    if (job.active()) {
      // Nothing was received from anybody meanwhile.
      if (arm_stands) job.absent_since = now - *absence;
      RestoreOne(job, arm_stands, now);
    } else {
      job.armed = false;  // what waits for its machine is not armed
      actions_.Progressed(job);
    }
  }
}

void JobQueue::RestoreOne(JobRecord& job, bool arm_stands, Nanoseconds now) {
  const bool waited = job.state == intaglio_JOB_PAUSED && !job.armed;
  if (job.ever_granted) {
    job.armed = false;
    const std::string& synchronizer = job.stage(intaglio_STAGE_ENGRAVE).worker;
    if (!synchronizer.empty()) {
      workers_.Assign(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE), now);
      workers_.Answered(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE));
    }
    if (arm_stands) GoOn(job, now);
    // What waits for a person keeps its reason.
    if (waited) return Change(job, intaglio_JOB_PAUSED, job.message);
    if (!job.armed) Disarm(job, "the job service was restarted", now);
    return ChangeToPaused(
        job, intaglio_PAUSE_RESTART,
        job.armed ? "the job service was restarted; the job goes on by itself"
                  : "the job service was restarted while this job was engraved; "
                    "resume it if the block was not touched, or cancel it");
  }
  Requeue(job, "the job service was restarted", now);
  for (const GivenTask& given : job.GivenTasks()) Revoke(job, given, now);
}

void JobQueue::Add(JobRecord job) {
  in_turn_[TurnOf(job)] = job.uid;
  JobRecord& added = jobs_[job.uid] = std::move(job);
  Change(added, intaglio_JOB_QUEUED, "");
}

const JobRecord* JobQueue::Find(const std::string& job_uid) const {
  const auto found = jobs_.find(job_uid);
  return found == jobs_.end() ? nullptr : &found->second;
}

JobRecord* JobQueue::FindOpen(const std::string& job_uid) {
  const auto found = jobs_.find(job_uid);
  return found == jobs_.end() || found->second.ended() ? nullptr : &found->second;
}

void JobQueue::Change(JobRecord& job, intaglio_JobState state,
                      const std::string& message) {
  job.state = state;
  if (state != intaglio_JOB_PAUSED) job.pause_reason = intaglio_PAUSE_NONE;
  job.message = message;
  ++job.revision;
  actions_.Changed(job);
}

void JobQueue::Tell(JobRecord& job, intaglio_JobState state, const std::string& message) {
  if (state != job.state) return Change(job, state, message);
  job.message = message;
  ++job.revision;
  actions_.Progressed(job);
}

void JobQueue::EndJob(JobRecord& job, intaglio_JobState state, const std::string& message,
                      Nanoseconds now) {
  Disarm(job, message, now);
  Change(job, state, message);
  RevokeAll(job, now);
  ended_.Add(job.uid, now);
  job.frozen_job = {};  // up to a megabyte that nobody needs any more
}

void JobQueue::Forget(Nanoseconds now) {
  std::erase_if(in_turn_,
                [this](const auto& entry) { return jobs_.at(entry.second).ended(); });
  while (const auto uid = ended_.TakeOldest(now)) {
    const auto job = jobs_.find(*uid);
    actions_.Forgotten(job->second);
    jobs_.erase(job);
  }
  for (const std::string& instance : workers_.ForgetLost(now)) {
    actions_.WorkerForgotten(instance);
  }
}

// ---- Handing out --------------------------------------------------------------------

bool JobQueue::CellIsTaken(const std::string& cell) const {
  for (const auto& [uid, job] : jobs_) {
    if (job.active() && job.cell == cell) return true;
  }
  return false;
}

void JobQueue::Turn(Nanoseconds now) {
  EndAbsences(now);
  GiveUpSilent(now);
  Forget(now);
  // A discretizer is of more use to a job that is under way than to the next one.
  for (const auto& [turn, uid] : in_turn_) GiveOpenParts(jobs_.at(uid), now);
  for (const auto& [turn, uid] : in_turn_) TakeUp(jobs_.at(uid), now);
  std::set<std::string> cells;  // whose first waiting job had its chance
  for (const auto& [turn, uid] : in_turn_) {
    JobRecord& job = jobs_.at(uid);
    if (job.state != intaglio_JOB_QUEUED) continue;
    if (!cells.insert(job.cell).second || CellIsTaken(job.cell)) {
      WaitFor(job,
              fmt::format("its turn on {}; arm it then, with its block in the machine",
                          job.cell));
    } else {
      HandOut(job, now);
    }
  }
}

void JobQueue::HandOut(JobRecord& job, Nanoseconds now) {
  std::array<std::vector<std::string>, 3> workers;
  std::vector<std::string> missing;
  for (const intaglio_Stage stage :
       {intaglio_STAGE_ENGRAVE, intaglio_STAGE_SORT, intaglio_STAGE_DISCRETIZE}) {
    workers[stage] = workers_.Free(RoleOf(stage), job.cell);
    if (workers[stage].empty())
      missing.push_back(workers_.WhyNone(RoleOf(stage), job.cell));
  }
  if (missing.empty()) return Begin(job, workers, now);
  WaitFor(job, fmt::format("{}", fmt::join(missing, ", ")));
}

void JobQueue::WaitFor(JobRecord& job, const std::string& what) {
  const std::string before = job.last_loss.empty() ? "" : job.last_loss + "; ";
  const std::string message = fmt::format("{}waits for {}", before, what);
  if (message != job.message) Change(job, intaglio_JOB_QUEUED, message);
}

// The consumer of a stream gets its task before the producer does.
void JobQueue::Begin(JobRecord& job,
                     const std::array<std::vector<std::string>, 3>& workers,
                     Nanoseconds now) {
  ++job.attempt;
  job.estimate_ticks = 0;
  for (const intaglio_Stage stage : kStages) job.stage(stage) = {};
  const std::string& synchronizer = workers[intaglio_STAGE_ENGRAVE].front();
  const std::string& sorter = workers[intaglio_STAGE_SORT].front();
  job.stage(intaglio_STAGE_ENGRAVE).worker = synchronizer;
  job.stage(intaglio_STAGE_SORT).worker = sorter;
  CutIntoParts(job, workers[intaglio_STAGE_DISCRETIZE], now);
  Change(job, intaglio_JOB_DISCRETIZING,
         job.last_loss.empty()
             ? ""
             : fmt::format("attempt {}: {}", job.attempt, job.last_loss));
  GiveTask(job, intaglio_STAGE_ENGRAVE, synchronizer, {}, now);
  GiveTask(job, intaglio_STAGE_SORT, sorter, synchronizer, now);
  for (std::uint32_t part = 0; part < job.parts.size(); ++part) {
    const std::string& worker = job.parts[part].worker;
    if (worker.empty()) continue;
    workers_.Assign(worker, job.TaskOf(intaglio_STAGE_DISCRETIZE, part), now);
    GivePart(job, part);
  }
}

void JobQueue::GiveTask(JobRecord& job, intaglio_Stage stage, const std::string& worker,
                        const std::string& consumer, Nanoseconds now) {
  workers_.Assign(worker, job.TaskOf(stage), now);
  actions_.Give({worker, stage, job.TaskOf(stage), consumer, false}, job);
}

void JobQueue::RevokeAll(JobRecord& job, Nanoseconds now) {
  Revoke(job, job.GivenTasks(), now);
}

void JobQueue::Revoke(JobRecord& job, const std::vector<GivenTask>& tasks,
                      Nanoseconds now) {
  actions_.StopFeed(job.uid);
  RevokeStanding(job, tasks, now);
}

// First which, for one revocation takes the others of its worker out of the book.
void JobQueue::RevokeStanding(JobRecord& job, std::vector<GivenTask> tasks,
                              Nanoseconds now) {
  std::erase_if(tasks, [this](const GivenTask& given) {
    return !workers_.IsAssigned(given.worker, given.task);
  });
  for (const GivenTask& given : tasks) Revoke(job, given, now);
}

void JobQueue::Revoke(JobRecord& job, const GivenTask& given, Nanoseconds now) {
  workers_.Revoke(given.worker, given.task, now);
  const bool goes_on =
      given.stage == intaglio_STAGE_ENGRAVE && job.ever_granted && !job.ended();
  actions_.Give({given.worker, given.stage, given.task, {}, true, goes_on}, job);
}

// ---- Workers ------------------------------------------------------------------------

void JobQueue::Take(const WorkerView& worker, Nanoseconds now) {
  workers_.Update(worker, now);
  // It ends in order, and its process was asked to.
  if (worker.role == intaglio_ROLE_SYNCHRONIZER &&
      worker.state == intaglio_HEALTH_STOPPING) {
    CloseCell(worker.instance, now);
  }
}

void JobQueue::WorkerLost(const std::string& instance, Nanoseconds now) {
  const WorkerBook::Assignments lost = workers_.Lose(instance, now);
  if (!lost.task.revoked) LoseTasks(instance, lost, instance + " was lost", now);
}

void JobQueue::GiveUpSilent(Nanoseconds now) {
  for (const auto& [instance, has] : workers_.Silent(now, kAnswerWithin)) {
    LoseTasks(instance, has, instance + " does not answer", now);
  }
}

void JobQueue::LoseTasks(const std::string& instance, const WorkerBook::Assignments& has,
                         const std::string& why, Nanoseconds now) {
  LoseNextPart(instance, has.next.task);
  LoseTask(instance, has.task.task, why, now);
}

void JobQueue::LoseTask(const std::string& instance, const TaskId& task,
                        const std::string& why, Nanoseconds now) {
  JobRecord* job = FindOpen(task.job_uid);
  if (job == nullptr || job->attempt != task.attempt) return;
  for (const GivenTask& given : job->GivenTasks()) {
    if (given.worker != instance || given.task != task) continue;
    if (given.stage == intaglio_STAGE_DISCRETIZE) {
      return LosePart(*job, task.part, why, 0s, now);
    }
    return LoseStage(*job, given.stage, why, now);
  }
}

void JobQueue::LoseStage(JobRecord& job, intaglio_Stage stage, const std::string& why,
                         Nanoseconds now) {
  if (job.stage(stage).done || !job.active()) return;
  if (stage != intaglio_STAGE_ENGRAVE || !job.ever_granted)
    return LoseAttempt(job, why, now);
  LoseEngraving(job, why, now);
}

void JobQueue::LoseAttempt(JobRecord& job, const std::string& why, Nanoseconds now) {
  ++job.lost_attempts;
  job.last_loss = fmt::format("attempt {} broke: {}", job.attempt, why);
  if (job.lost_attempts >= kMaxAttempts) {
    return EndJob(
        job, intaglio_JOB_FAILED,
        fmt::format("given up after {} attempts; {}", job.lost_attempts, job.last_loss),
        now);
  }
  Requeue(job, job.last_loss, now);
  RevokeAll(job, now);
}

void JobQueue::Requeue(JobRecord& job, const std::string& why, Nanoseconds now) {
  job.last_loss = why;
  if (job.armed) {
    job.last_loss += "; it is not armed any more: arm it when it has its machine again";
  }
  Disarm(job, why, now);
  Change(job, intaglio_JOB_QUEUED, job.last_loss);
}

void JobQueue::FeedFailed(const std::string& job_uid, std::uint32_t attempt,
                          const std::string& message, Nanoseconds now) {
  JobRecord* job = FindOpen(job_uid);
  if (job == nullptr || job->attempt != attempt || !job->active()) return;
  EndJob(*job, intaglio_JOB_FAILED, message, now);
}

// ---- Tasks --------------------------------------------------------------------------

void JobQueue::Take(const TaskView& task, Nanoseconds now) {
  const bool over =
      task.state == intaglio_TASK_DONE || task.state == intaglio_TASK_FAILED;
  if (AnswersAnOldRevocation(task)) return;
  if (over) {
    workers_.Release(task.worker, task.task, now);
  } else {
    workers_.Answered(task.worker, task.task);
  }
  JobRecord* job = FindOpen(task.task.job_uid);
  if (job == nullptr || !job->active() || task.task.attempt != job->attempt) return;
  if (task.stage == intaglio_STAGE_DISCRETIZE) return TakePart(*job, task, now);
  StageRecord& stage = job->stage(task.stage);
  if (stage.worker != task.worker) return;
  stage.done_count = task.done_count;
  stage.total_count = task.total_count;
  stage.elapsed_s = task.elapsed_s;
  if (task.state == intaglio_TASK_FAILED) return StageFailed(*job, task, now);
  if (task.state == intaglio_TASK_DONE) return StageDone(*job, task, now);
  if (task.stage == intaglio_STAGE_ENGRAVE) return EngraveStatus(*job, task, now);
  Tell(*job, job->state, job->message);
}

void JobQueue::StageFailed(JobRecord& job, const TaskView& task, Nanoseconds now) {
  const bool in_parts = task.stage == intaglio_STAGE_DISCRETIZE;
  const bool glass_is_clear = task.stage != intaglio_STAGE_ENGRAVE || !job.ever_granted;
  if (job.stage(task.stage).done) return;
  const std::string what = fmt::format("{}: {}", task.worker, task.message);
  if (glass_is_clear && MayBeANeighbours(task.error_code)) {
    return in_parts ? LosePart(job, task.task.part, what, kPartPause, now)
                    : LoseAttempt(job, what, now);
  }
  EndJob(job, intaglio_JOB_FAILED, task.message.empty() ? what : task.message, now);
}

void JobQueue::StageDone(JobRecord& job, const TaskView& task, Nanoseconds now) {
  FinishParts(job, now);
  job.stage(task.stage).done = true;
  if (task.stage == intaglio_STAGE_ENGRAVE) {
    return EndJob(job, intaglio_JOB_DONE, task.message, now);
  }
  Change(job, job.state == intaglio_JOB_DISCRETIZING ? intaglio_JOB_SORTING : job.state,
         job.message);
}

void JobQueue::EngraveStatus(JobRecord& job, const TaskView& task, Nanoseconds now) {
  job.absent_since.reset();
  if (task.estimate_ticks != 0) job.estimate_ticks = task.estimate_ticks;
  if (task.state == intaglio_TASK_PAUSED) {
    const bool has_path = task.total_count > 0;
    return has_path ? EngravePaused(job, task, now) : SpentBeforehand(job, task, now);
  }
  const bool loaded = task.state == intaglio_TASK_RUNNING && task.total_count > 0;
  const bool held = job.state == intaglio_JOB_PAUSED && !job.armed;
  if (!loaded || held) return Tell(job, job.state, job.message);
  // The whole path is there: nobody needs the earlier stages any more.
  FinishParts(job, now);
  job.stage(intaglio_STAGE_SORT).done = true;
  Tell(job, task.done_count > 0 ? intaglio_JOB_ENGRAVING : intaglio_JOB_WAITING_FOR_ARM,
       task.message);
}

}  // namespace intaglio::job_service
