#pragma once

// What becomes of every job: pure decisions, without bus, clock, disk or thread.
//
// clang-format off
//            workers free            points made            path is there
//   kQueued -------------> kDiscretizing -------> kSorting ---------------> kWaitingForArm
//      ^                      |                      |                            |
//      +--- a worker lost ----+----------------------+                            | armed
//      |    (the third: kFailed)                                                  v
//      |                                                                     kEngraving --> kDone
//      |                                  fault, pause, loss of the synchronizer |  ^
//      |                                                                         v  | resumed, or
//      +------- nothing was made, as it turns out ---------------------------- kPaused  by itself
//
//   any --cancel--> kCancelled      any --a worker gives up--> kFailed
// clang-format on
//
// Discretizing is cut into parts, which discretizers take one after another, the next one
// while they are at the one before; a lost discretizer costs its part's time and no
// attempt (job_parts.cc). A part that is lost too often fails the job.
//
// One job at a time has a cell, from its first task to its end: a paused job keeps it,
// for its block is in the machine. Of the jobs that wait the one of the highest priority
// is next, of equal ones the first submitted. A person arms a job for the block that is
// in the machine, so only a job that has its cell can be armed, and one that is queued
// again is disarmed. A job that may have pulses in the glass never begins anew: the next
// synchronizer of its cell takes it up from its journal, and after a loss, not after a
// fault, it goes on without the operator (job_take_up.cc). Attempts are numbered per job;
// what an older attempt says is dropped. Used from one thread.
//
// An ended job leaves this class when kRememberedJobs have ended after it, kRememberedFor
// after its end at the earliest; the database keeps it (job_store.h).

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "services/job_service/ended_list.h"
#include "services/job_service/job_record.h"
#include "services/job_service/worker_book.h"

namespace intaglio::job_service {

/// A task for a worker, or its revocation.
struct TaskOrder {
  std::string worker;
  intaglio_Stage stage = intaglio_STAGE_DISCRETIZE;
  TaskId task;
  std::string consumer;  ///< instance that takes the output; empty: none
  bool revoked = false;
  /// What another worker began: path and journal are on disk. Of a revocation: it will
  /// be taken up again.
  bool take_up = false;
};

/// What the queue decides is done by somebody else.
class JobActions {
 public:
  virtual ~JobActions() = default;
  /// To be kept before anything that follows from it, and published.
  virtual void Changed(const JobRecord& job) = 0;
  /// To be published; nothing is lost when it is forgotten.
  virtual void Progressed(const JobRecord& job) = 0;
  /// To be told to the worker. A discretizer that has not got the job's models yet asks
  /// for them with this task.
  virtual void Give(const TaskOrder& order, const JobRecord& job) = 0;
  /// No discretizer needs the job's models any more.
  virtual void StopFeed(const std::string& job_uid) = 0;
  /// An ended job leaves the queue: its status is withdrawn from the bus.
  virtual void Forgotten(const JobRecord& job) = 0;
  /// So does a worker that was lost long ago: its task is withdrawn.
  virtual void WorkerForgotten(const std::string& instance) = 0;
};

/// JobCommand.
struct CommandView {
  std::string sender;
  std::uint64_t number = 0;
  std::string job_uid;
  std::uint64_t epoch = 0;
  intaglio_JobCommandKind kind = intaglio_COMMAND_ARM;
  std::string operator_name;
  std::uint64_t disarm_count = 0;
  std::uint32_t from_point = 0;
  bool fire_uncertain = false;
  std::uint32_t speed_percent = 100;
};
inline constexpr std::uint32_t kMinSpeedPercent = 10;

/// JobCommandAnswer.
struct CommandAnswer {
  intaglio_CommandAnswerCode code = intaglio_ANSWER_TAKEN;
  std::string message;  ///< one sentence a person can act on; empty when taken
  bool taken() const { return code == intaglio_ANSWER_TAKEN; }
};

/// TaskStatus, without its outcome.
struct TaskView {
  TaskId task;
  intaglio_Stage stage = intaglio_STAGE_DISCRETIZE;
  std::string worker;
  intaglio_TaskState state = intaglio_TASK_ACCEPTED;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  double elapsed_s = 0;
  std::uint64_t estimate_ticks = 0;
  intaglio_ErrorCode error_code = intaglio_ERROR_NONE;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;
  std::string message;
};

/// Permission of one cell; a cell without an armed job has none.
struct PermissionView {
  std::string cell;
  std::string job_uid;
  std::uint64_t epoch = 0;
  bool granted = false;
  std::string operator_name;
  std::uint32_t speed_percent = 100;
  std::uint64_t grant = 0, renewal = 0;
  std::uint32_t first_point = 0;
  bool fire_uncertain = false;
};

/// Chains of a job that may break before it is given up.
inline constexpr std::uint32_t kMaxAttempts = 3;

/// Ended jobs that stay in memory and on the bus, the newest: what `intaglio list` shows.
inline constexpr std::size_t kRememberedJobs = 100;
/// An end stays on the bus for so long at least. A client that was stopped or cut off
/// reads it when it is back within this time; whoever comes later reads the history.
inline constexpr std::chrono::seconds kRememberedFor{60};

/// Parts for so many discretizers: one for one, else so many that one that is slow or
/// ends last is waited for an eighth of its share at most.
std::uint32_t PartCountFor(std::size_t discretizers);

class JobQueue {
 public:
  explicit JobQueue(JobActions& actions) : actions_(actions) {}

  /// Jobs of an earlier run of the job service, before any other call.
  /// Chains in hand start over; jobs that may have pulses in the glass are paused, and go
  /// on by themselves if `absence`, for how long there was no job service on this machine
  /// since it was switched on, is within host::kMaxAbsence. nullopt: not known.
  void Restore(std::vector<JobRecord> jobs, std::optional<Nanoseconds> absence,
               Nanoseconds now);
  void Add(JobRecord job);

  void Take(const WorkerView& worker, Nanoseconds now);
  void WorkerLost(const std::string& instance, Nanoseconds now);
  /// Unless it is taken, nothing was changed. PAUSE and CANCEL of an open job are always
  /// taken; ARM and RESUME only when no pause, stop or disarming came after the status on
  /// which the sender acted (disarm_count), in whatever order they arrive. Which commands
  /// were answered before the caller knows.
  CommandAnswer Take(const CommandView& command, Nanoseconds now);
  void Take(const TaskView& task, Nanoseconds now);
  /// A model file could not be read or sent.
  void FeedFailed(const std::string& job_uid, std::uint32_t attempt,
                  const std::string& message, Nanoseconds now);
  /// Hands out what can be handed out. After any of the above, and now and then.
  void Turn(Nanoseconds now);

  /// An emergency stop is pressed there, or not any more: what is armed there is not any
  /// more, and is not armed anew while it is pressed.
  void SetStop(const std::string& cell, bool pressed, Nanoseconds now);

  /// A person closes the shop: whoever opens it again arms again.
  void Close(Nanoseconds now);

  /// For every cell that has a job. A first grant is kept (Changed) before it is told.
  std::vector<PermissionView> Permissions(Nanoseconds now);

  const JobRecord* Find(const std::string& job_uid) const;
  /// It is about an engraving that this worker was given anew since.
  bool AnswersAnOldRevocation(const TaskView& task) const;
  const std::map<std::string, JobRecord>& jobs() const { return jobs_; }

 private:
  JobRecord* FindOpen(const std::string& job_uid);
  /// Takes ended jobs out of the turn, and jobs and workers out of memory that may be
  /// forgotten.
  void Forget(Nanoseconds now);
  void RestoreOne(JobRecord& job, bool arm_stands, Nanoseconds now);
  void HandOut(JobRecord& job, Nanoseconds now);
  /// The workers of the three stages, of the last two one each.
  void Begin(JobRecord& job, const std::array<std::vector<std::string>, 3>& workers,
             Nanoseconds now);
  void GiveTask(JobRecord& job, intaglio_Stage stage, const std::string& worker,
                const std::string& consumer, Nanoseconds now);
  void WaitFor(JobRecord& job, const std::string& what);
  void GiveUpSilent(Nanoseconds now);
  bool CellIsTaken(const std::string& cell) const;
  void Change(JobRecord& job, intaglio_JobState state, const std::string& message);
  void ChangeToPaused(JobRecord& job, intaglio_PauseReason reason,
                      const std::string& message);
  /// As Change when the state differs; a message alone is told and not kept.
  void Tell(JobRecord& job, intaglio_JobState state, const std::string& message);
  void EndJob(JobRecord& job, intaglio_JobState state, const std::string& message,
              Nanoseconds now);
  void RevokeAll(JobRecord& job, Nanoseconds now);
  void Revoke(JobRecord& job, const std::vector<GivenTask>& tasks, Nanoseconds now);
  /// Those of these tasks that a worker still has.
  void RevokeStanding(JobRecord& job, std::vector<GivenTask> tasks, Nanoseconds now);
  void Revoke(JobRecord& job, const GivenTask& given, Nanoseconds now);
  void LoseTasks(const std::string& instance, const WorkerBook::Assignments& has,
                 const std::string& why, Nanoseconds now);
  void LoseTask(const std::string& instance, const TaskId& task, const std::string& why,
                Nanoseconds now);
  void LoseAttempt(JobRecord& job, const std::string& why, Nanoseconds now);
  void LoseStage(JobRecord& job, intaglio_Stage stage, const std::string& why,
                 Nanoseconds now);
  /// Taken when nothing forbids it.
  CommandAnswer Check(const JobRecord& job, const CommandView& command) const;
  CommandAnswer CheckArm(const JobRecord& job, const CommandView& command) const;
  void Arm(JobRecord& job, const CommandView& command, Nanoseconds now);
  void Pause(JobRecord& job, const CommandView& command, Nanoseconds now);
  /// Also of a job that is not armed: an ARM on its way has no effect. A Change follows.
  void Disarm(JobRecord& job, const std::string& reason, Nanoseconds now);
  /// It leaves its machine, to wait for another attempt; its arm does not wait with it.
  void Requeue(JobRecord& job, const std::string& why, Nanoseconds now);
  void StageFailed(JobRecord& job, const TaskView& task, Nanoseconds now);
  void StageDone(JobRecord& job, const TaskView& task, Nanoseconds now);
  // The parts of the discretizing: job_parts.cc.
  void CutIntoParts(JobRecord& job, const std::vector<std::string>& discretizers,
                    Nanoseconds now);
  void GivePart(JobRecord& job, std::uint32_t part);
  void GiveOpenParts(JobRecord& job, Nanoseconds now);
  void GivePartsAhead(JobRecord& job, Nanoseconds now);
  void TakePart(JobRecord& job, const TaskView& task, Nanoseconds now);
  void PartDone(JobRecord& job, Nanoseconds now);
  /// `pause` before it is given again.
  void LosePart(JobRecord& job, std::uint32_t part, const std::string& why,
                Nanoseconds pause, Nanoseconds now);
  /// One that was given ahead.
  void LoseNextPart(const std::string& instance, const TaskId& task);
  void FinishParts(JobRecord& job, Nanoseconds now);
  void TellDiscretizing(JobRecord& job);

  // After the loss of a synchronizer or a line: job_take_up.cc.
  void LoseEngraving(JobRecord& job, const std::string& why, Nanoseconds now);
  void TakeUp(JobRecord& job, Nanoseconds now);
  /// Of synchronizers, or of this job service between two turns.
  void EndAbsences(Nanoseconds now);
  /// A person closed the cell of this synchronizer.
  void CloseCell(const std::string& synchronizer, Nanoseconds now);
  /// Why the arm of this job ends; empty: it does not.
  using WhyItEnds = std::function<std::string(const JobRecord& job)>;
  void EndArms(intaglio_PauseReason reason, Nanoseconds now, const WhyItEnds& why);
  void EndArm(JobRecord& job, intaglio_PauseReason reason, const std::string& why,
              Nanoseconds now);
  /// Arms it as it was armed, a while later; not for ever without a point made.
  void GoOn(JobRecord& job, Nanoseconds now);

  void EngraveStatus(JobRecord& job, const TaskView& task, Nanoseconds now);
  /// Its arm was spent before it had a path.
  void SpentBeforehand(JobRecord& job, const TaskView& task, Nanoseconds now);
  void EngravePaused(JobRecord& job, const TaskView& task, Nanoseconds now);

  JobActions& actions_;
  WorkerBook workers_;
  std::map<std::string, JobRecord> jobs_;  // by uid
  std::set<std::string> stopped_cells_;    // an emergency stop is pressed there
  std::optional<Nanoseconds> last_turn_;
  // The queue's order: {-priority, number}.
  std::map<std::pair<std::int32_t, std::uint32_t>, std::string> in_turn_;  // open jobs
  EndedList ended_{kRememberedJobs, kRememberedFor};
};

}  // namespace intaglio::job_service
