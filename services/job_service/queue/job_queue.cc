#include "services/job_service/queue/job_queue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <utility>

#include "engrave/core/counted.h"
#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// A worker's loop turns many times a second, and its health comes five times: one that is
// silent so long never got its task, or hangs.
constexpr Nanoseconds kAnswerWithin = 10s;
// The health of the services of a cell is read from its first open job on: it comes every
// 600 ms from each, and from all that run within this.
constexpr Nanoseconds kReportsWithin = 2s;

// A part that failed for want of its neighbour waits until a dead sorter, which may be
// the reason, is missed (its lease is 1.5 s): that costs the attempt, and none of the
// part's attempts.
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

}  // namespace

// ---- Jobs ---------------------------------------------------------------------------

void JobQueue::Restore(std::vector<JobRecord> jobs, std::optional<Nanoseconds> absence,
                       Nanoseconds now) {
  const bool was_short = absence && *absence <= host::kMaxAbsence;
  for (JobRecord& restored : jobs) {
    if (restored.ended()) {
      book_.AddEnded(std::move(restored), now);
      continue;
    }
    JobRecord& job = book_.Add(std::move(restored));
    job.place = PlaceOf(job.frozen_job);
    if (!job.active()) {
      job.arm.Drop();  // what waits for its machine is not armed
      book_.PublishRestored(job);
      continue;
    }
    const bool arm_counts =
        job.arm.armed() && was_short && !job.arm.kept().asks_before_resume;
    // Nothing was received from any process meanwhile.
    if (arm_counts) job.arm.BeginAbsence(now - *absence);
    if (job.arm.ever_granted()) {
      take_up_.Restore(job, arm_counts, now);
      continue;
    }
    Requeue(job, "the job service was restarted", now);
    for (const GivenTask& given : job.GivenTasks()) tasks_.Revoke(job, given, now);
  }
}

void JobQueue::Add(JobRecord job) {
  job.place = PlaceOf(job.frozen_job);
  book_.Change(book_.AddNew(std::move(job)), intaglio_JOB_QUEUED, "");
}

void JobQueue::EndJob(JobRecord& job, intaglio_JobState state, const std::string& message,
                      Nanoseconds now) {
  job.arm.Disarm(message, now);
  book_.End(job, state, message, now);
  tasks_.RevokeAndStopFeed(job, job.GivenTasks(), now);
  discretizing_.comparing().Drop(job);
  job.frozen_job = {};  // up to a megabyte that is not needed any more
}

CommandAnswer JobQueue::Receive(const CommandView& command, Nanoseconds now) {
  JobRecord* job = book_.Find(command.job_uid);
  if (job == nullptr) {
    return {intaglio_ANSWER_UNKNOWN_JOB,
            fmt::format("no job {}: see intaglio list", command.job_uid)};
  }
  if (job->arm.IsRepeated(command)) return {};
  CommandAnswer answer = arming_.Check(*job, command);
  if (answer.taken()) Apply(*job, command, now);
  return answer;
}

void JobQueue::Apply(JobRecord& job, const CommandView& command, Nanoseconds now) {
  job.arm.Note(command);
  switch (command.kind) {
    case intaglio_COMMAND_PAUSE:
      return arming_.Pause(job, command, now);
    case intaglio_COMMAND_CANCEL:
      return EndJob(job, intaglio_JOB_CANCELLED, "cancelled by " + command.operator_name,
                    now);
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      return arming_.Arm(job, command, now);
    case intaglio_COMMAND_SPEED:
      job.speed_percent = command.speed_percent;
      return book_.Change(job, job.state, job.message);
    case intaglio_COMMAND_MOVE:
      return book_.Move(job, command.before_job_uid);
    case intaglio_COMMAND_MOUNT:
    case intaglio_COMMAND_ADMIT:
      break;  // of a machine, of a worker
  }
}

// ---- Handing out --------------------------------------------------------------------

void JobQueue::Turn(Nanoseconds now) {
  take_up_.EndAbsences(now);
  for (const auto& [instance, has] : tasks_.workers().Silent(now, kAnswerWithin)) {
    LoseTasks(instance, has, instance + " does not answer", now);
  }
  book_.Forget(now);
  tasks_.ForgetLost(now);
  tasks_.workers().EndSlow(now);
  RemakeWrong(now);
  // A discretizer is of more use to a job that is under way than to the next one.
  for (JobRecord* job : book_.ActiveInTurn()) discretizing_.GiveOpen(*job, now);
  for (JobRecord* job : book_.ActiveInTurn()) take_up_.GiveToFree(*job, now);
  StartWaiting(now);
  arming_.TurnPieces();
  for (JobRecord* job : book_.ActiveInTurn()) discretizing_.comparing().Hold(*job, now);
}

void JobQueue::StartWaiting(Nanoseconds now) {
  if (placed_revision_ != book_.waiting_revision()) return PlaceWaiting(now);
  for (JobRecord* job : next_)
    if (job->state == intaglio_JOB_QUEUED) StartFirst(*job, now);
}

// In the order of the places: a client that has some of them has the first ones.
void JobQueue::PlaceWaiting(Nanoseconds now) {
  placed_revision_ = book_.waiting_revision();
  next_.clear();
  std::map<std::string, std::uint32_t> waiting;  // by cell
  for (JobRecord* job : book_.InTurn()) {
    if (job->state != intaglio_JOB_QUEUED) continue;
    const std::uint32_t place = ++waiting[job->cell];
    if (place == 1) {
      next_.push_back(job);
      StartFirst(*job, now);
    } else if (std::exchange(job->queue_place, place) != place) {
      WaitForTurn(*job);
      book_.PublishProgress(*job);
    }
  }
}

void JobQueue::StartFirst(JobRecord& job, Nanoseconds now) {
  const bool has_moved = std::exchange(job.queue_place, 1u) != 1;
  if (book_.CellIsTaken(job.cell)) {
    WaitForTurn(job);
  } else {
    HandOut(job, now);
  }
  if (has_moved && job.state == intaglio_JOB_QUEUED) book_.PublishProgress(job);
}

void JobQueue::WaitForTurn(JobRecord& job) {
  WaitFor(job, fmt::format("its turn on {}; arm it then, with its {} in the machine",
                           job.cell, job.workpiece()));
}

void JobQueue::HandOut(JobRecord& job, Nanoseconds now) {
  if (!job.first_handout) job.first_handout = now;
  const bool all_reported = now - *job.first_handout >= kReportsWithin;
  std::array<std::vector<std::string>, 3> workers;
  std::vector<std::string> missing;
  for (const intaglio_Stage stage :
       {intaglio_STAGE_ENGRAVE, intaglio_STAGE_SORT, intaglio_STAGE_DISCRETIZE}) {
    workers[stage] = tasks_.workers().Free(RoleOf(stage), job.cell);
    if (workers[stage].empty())
      missing.push_back(
          tasks_.workers().WhyNone(RoleOf(stage), job.cell, job.maker(), all_reported));
  }
  if (missing.empty()) return Begin(job, workers, now);
  WaitFor(job, fmt::format("{}", fmt::join(missing, ", ")));
}

void JobQueue::WaitFor(JobRecord& job, const std::string& what) {
  const std::string before = job.last_loss.empty() ? "" : job.last_loss + "; ";
  const std::string message = fmt::format("{}waits for {}", before, what);
  if (message != job.message) book_.Change(job, intaglio_JOB_QUEUED, message);
}

// The consumer of a stream gets its task before the producer does.
void JobQueue::Begin(JobRecord& job,
                     const std::array<std::vector<std::string>, 3>& workers,
                     Nanoseconds now) {
  ++job.attempt;
  job.estimate_ticks = job.first_estimate_ticks = 0;
  job.warnings.clear();
  job.counts = {};
  for (const intaglio_Stage stage : kStages) job.stage(stage) = {};
  const std::string& synchronizer = workers[intaglio_STAGE_ENGRAVE].front();
  const std::string& sorter = workers[intaglio_STAGE_SORT].front();
  job.stage(intaglio_STAGE_ENGRAVE).worker = synchronizer;
  job.stage(intaglio_STAGE_SORT).worker = sorter;
  Discretizing::Cut(job, workers[intaglio_STAGE_DISCRETIZE], now);
  book_.Change(job, intaglio_JOB_DISCRETIZING,
               job.last_loss.empty()
                   ? ""
                   : fmt::format("attempt {}: {}", job.attempt, job.last_loss));
  tasks_.Give(job, intaglio_STAGE_ENGRAVE, synchronizer, {}, now);
  tasks_.Give(job, intaglio_STAGE_SORT, sorter, synchronizer, now);
  discretizing_.GiveFirst(job, now);
}

// ---- Tasks --------------------------------------------------------------------------

bool JobQueue::MayKnow(const TaskView& task) const {
  return task.stage == intaglio_STAGE_ENGRAVE ||
         tasks_.workers().HasOrHad(task.worker, task.task);
}

void JobQueue::Receive(const TaskView& task, Nanoseconds now) {
  if (AnswersAnOldRevocation(task)) return;
  if (task.ended()) {
    tasks_.workers().Release(task.worker, task.task, now);
  } else {
    tasks_.workers().Answered(task.worker, task.task);
  }
  JobRecord* job = book_.FindOpen(task.task.job_uid);
  if (job == nullptr || !job->active() || task.task.attempt != job->attempt) return;
  if (task.warnings) arming_.TakeWarnings(*job, *task.warnings, now);
  if (task.stage == intaglio_STAGE_DISCRETIZE) return TakePart(*job, task, now);
  StageRecord& stage = job->stage(task.stage);
  if (stage.worker != task.worker) return;
  stage.done_count = task.done_count;
  stage.total_count = task.total_count;
  stage.elapsed_s = task.elapsed_s;
  if (task.stage == intaglio_STAGE_ENGRAVE) {
    job->counts = task.counts;
    job->alarm = task.alarm;
    job->at_work.clear();
  }
  if (task.state == intaglio_TASK_FAILED) return StageFailed(*job, task, now);
  if (task.state == intaglio_TASK_DONE) return StageDone(*job, task, now);
  if (task.stage == intaglio_STAGE_ENGRAVE) return EngraveStatus(*job, task, now);
  NoteFirstEstimate(*job, task);
  book_.PublishProgress(*job);
}

// The plan of the motion, which comes later, is better.
void JobQueue::NoteFirstEstimate(JobRecord& job, const TaskView& task) {
  if (task.estimate_ticks == 0 || job.first_estimate_ticks != 0) return;
  job.first_estimate_ticks = task.estimate_ticks;
  if (job.estimate_ticks == 0) job.estimate_ticks = task.estimate_ticks;
}

void JobQueue::TakePart(JobRecord& job, const TaskView& task, Nanoseconds now) {
  switch (discretizing_.Receive(job, task, now)) {
    case Discretizing::Outcome::kFailed:
      return StageFailed(job, task, now);
    case Discretizing::Outcome::kAllDone:
      return StageDone(job, task, now);
    case Discretizing::Outcome::kIgnored:
    case Discretizing::Outcome::kProgress:
      return;
  }
}

void JobQueue::StageFailed(JobRecord& job, const TaskView& task, Nanoseconds now) {
  const bool in_parts = task.stage == intaglio_STAGE_DISCRETIZE;
  const bool glass_is_clear =
      task.stage != intaglio_STAGE_ENGRAVE || !job.arm.ever_granted();
  if (job.stage(task.stage).done) return;
  const std::string what = fmt::format("{}: {}", task.worker, task.message);
  if (glass_is_clear && task.failed_by_neighbour()) {
    return in_parts ? LosePart(job, task.task.part, what, kPartPause, now)
                    : LoseAttempt(job, what, now);
  }
  EndJob(job, intaglio_JOB_FAILED, task.message.empty() ? what : task.message, now);
}

void JobQueue::StageDone(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (task.stage == intaglio_STAGE_SORT) NoteFirstEstimate(job, task);
  job.stage(task.stage).done = true;
  if (task.stage == intaglio_STAGE_ENGRAVE) {
    return EndJob(job, intaglio_JOB_DONE, task.message, now);
  }
  book_.Change(job,
               job.state == intaglio_JOB_DISCRETIZING ? intaglio_JOB_SORTING : job.state,
               job.shows_awaited_report() ? job.AwaitedReport() : job.message);
}

void JobQueue::EngraveStatus(JobRecord& job, const TaskView& task, Nanoseconds now) {
  job.arm.EndAbsence(now);
  if (task.estimate_ticks != 0) job.estimate_ticks = task.estimate_ticks;
  if (task.state == intaglio_TASK_PAUSED) return arming_.TakePaused(job, task, now);
  const bool loaded = task.state == intaglio_TASK_RUNNING && task.total_count > 0;
  const bool held = job.state == intaglio_JOB_PAUSED && !job.arm.armed();
  // A mark, or a contour that a mill follows, is not broken off by a pause.
  const bool is_at_work = task.counts.armed > 0;
  if (held && is_at_work) job.at_work = task.message;
  if (!loaded || held) return book_.PublishProgress(job);
  // The whole path is there. Reports of discretizers and sorter, with the warnings about
  // it, may still be on their way.
  const Warning* consent = job.open_consent();
  std::string unsettled = job.WhyNotSettled();
  if (unsettled.empty()) unsettled = job.AwaitedReport();
  const std::string misfit = job.arm.armed() ? "" : arming_.MountMisfitOf(job);
  book_.Publish(job,
                task.done_count > 0 || is_at_work ? intaglio_JOB_ENGRAVING
                                                  : intaglio_JOB_WAITING_FOR_ARM,
                !unsettled.empty()   ? unsettled
                : consent != nullptr ? Arming::ConsentMessage(job, *consent)
                : misfit.empty()     ? task.message
                                     : misfit);
}

}  // namespace intaglio::job_service
