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
// Composed of what has a state of its own:
//   JobBook       the jobs, their turn, and the publishing of their changes
//   TaskHandout   who works on what (WorkerBook), and the orders to workers
//   Discretizing  the parts of a job (JobParts) and the discretizers that make them
//   PieceBook     whose block is in each machine
//   MountBook     what is mounted in each machine
//   Arming        commands, emergency stops and permissions, by the arms (JobArm)
//   TakeUp        engravings after a loss, an absence or a restart
// This class is the way of a job through its stages.
//
// 1. One job at a time has a cell, from its first task to its end: a paused job keeps it,
//    for its block is in the machine. Of the jobs that wait the first in turn is next.
// 2. A job that is queued again is disarmed. A job that may have pulses in the glass
//    never begins anew: the next synchronizer of its cell takes it up from its journal.
// 3. Attempts are numbered per job; reports about an older attempt are dropped.
// Used from one thread.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/job_service/queue/arming.h"
#include "services/job_service/queue/discretizing.h"
#include "services/job_service/queue/job_book.h"
#include "services/job_service/queue/take_up.h"
#include "services/job_service/queue/task_handout.h"

namespace intaglio::job_service {

/// Chains of a job that may break before it is given up.
inline constexpr std::uint32_t kMaxAttempts = 3;

class JobQueue {
 public:
  explicit JobQueue(JobActions& actions)
      : book_(actions), tasks_(actions), pieces_(actions) {}
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// Jobs of an earlier run of the job service, before any other call.
  /// Chains in hand start over; jobs that may have pulses in the glass are paused, and go
  /// on by themselves if `absence`, for how long there was no job service on this machine
  /// since it was switched on, is within host::kMaxAbsence. nullopt: not known.
  void Restore(std::vector<JobRecord> jobs, std::optional<Nanoseconds> absence,
               Nanoseconds now);
  void Add(JobRecord job);

  void Receive(const WorkerView& worker, Nanoseconds now);
  void WorkerLost(const std::string& instance, Nanoseconds now);
  /// Unless it is taken, nothing was changed. PAUSE and CANCEL of an open job are always
  /// taken; ARM and RESUME as Arming allows. The caller knows which commands were
  /// answered before.
  CommandAnswer Receive(const CommandView& command, Nanoseconds now);
  void Receive(const TaskView& task, Nanoseconds now);
  /// A model file could not be read or sent.
  void FeedFailed(const std::string& job_uid, std::uint32_t attempt,
                  const std::string& message, Nanoseconds now);
  /// Hands out what can be handed out. After any of the above, and now and then.
  void Turn(Nanoseconds now);

  /// An emergency stop is pressed there, or not any more.
  void SetStop(const std::string& cell, bool pressed, Nanoseconds now) {
    arming_.SetStop(cell, pressed, now);
  }
  /// What was kept of the machines, before Restore.
  void RestoreCells(const std::vector<PieceRecord>& pieces,
                    const std::vector<LoadedBlock>& blocks,
                    std::vector<MountRecord> mounts) {
    pieces_.Restore(pieces, blocks);
    mounts_.Restore(std::move(mounts));
  }
  /// Whom an earlier run of the job service has left out, before Restore.
  void RestoreLeftOut(const std::vector<LeftOut>& workers, Nanoseconds now);
  void SetDoor(const std::string& cell, DoorState state) {
    pieces_.SetDoor(cell, state);
    arming_.TurnPieces();
  }
  const MountBook& mounts() const { return mounts_; }
  /// The record was made by mounts(), and is kept.
  void SetMount(const MountRecord& mount, intaglio_ArmBasis basis, Nanoseconds now) {
    arming_.SetMount(mount, basis, now);
  }
  /// A person closes the shop: the person who opens it again arms again.
  void Close(Nanoseconds now) { take_up_.CloseShop(now); }
  /// For every cell that has a job. A first grant is kept (Changed) before it is here.
  std::vector<PermissionView> Permissions(Nanoseconds now) {
    return arming_.Permissions(now);
  }

  const JobRecord* Find(const std::string& job_uid) const { return book_.Find(job_uid); }
  /// False: the report is about no attempt of which its worker has a task. A report about
  /// an engraving may always be known: its job may have ended long ago.
  bool MayKnow(const TaskView& task) const;
  /// As in TakeUp.
  bool AnswersAnOldRevocation(const TaskView& task) const {
    return take_up_.AnswersAnOldRevocation(task);
  }
  const std::map<std::string, JobRecord>& jobs() const { return book_.jobs(); }
  /// A person has mended a worker that was left out or slow: it is given tasks again.
  /// What it made before and is not engraved yet is made anew, for nobody has decided
  /// about it.
  CommandAnswer Admit(const std::string& worker, const std::string& operator_name,
                      Nanoseconds now);
  /// Living workers that are left out or slow, and why.
  std::map<std::string, std::string> LeftOutNow() const {
    return tasks_.workers().LeftOutNow();
  }
  /// Why workers are left out of the work, a sentence each.
  std::vector<std::string> Remarks() const { return tasks_.workers().Remarks(); }

 private:
  void Apply(JobRecord& job, const CommandView& command, Nanoseconds now);
  void StartWaiting(Nanoseconds now);
  /// Who is next on each machine, and the places of those behind. It looks at all that
  /// wait, so it is done when another one waits or the order is another one.
  void PlaceWaiting(Nanoseconds now);
  /// One that is next on its machine gets it, if it is free and the workers are.
  void StartFirst(JobRecord& job, Nanoseconds now);
  void WaitForTurn(JobRecord& job);
  void HandOut(JobRecord& job, Nanoseconds now);
  /// The workers of the three stages, of the last two one each.
  void Begin(JobRecord& job, const std::array<std::vector<std::string>, 3>& workers,
             Nanoseconds now);
  void WaitFor(JobRecord& job, const std::string& what);
  void EndJob(JobRecord& job, intaglio_JobState state, const std::string& message,
              Nanoseconds now);
  void LoseTasks(const std::string& instance, const WorkerBook::Assignments& has,
                 const std::string& why, Nanoseconds now);
  void LoseTask(const std::string& instance, const TaskId& task, const std::string& why,
                Nanoseconds now);
  void LosePart(JobRecord& job, std::uint32_t part, const std::string& why,
                Nanoseconds pause, Nanoseconds now);
  void LoseStage(JobRecord& job, intaglio_Stage stage, const std::string& why,
                 Nanoseconds now);
  void LoseAttempt(JobRecord& job, const std::string& why, Nanoseconds now);
  /// Requeue, and what its workers have is revoked.
  void EndAttempt(JobRecord& job, const std::string& why, Nanoseconds now);
  /// Every job that has a part of a discretizer that was found wrong begins anew, or is
  /// paused if its machine has begun.
  void RemakeWrong(Nanoseconds now);
  /// With a part of this worker.
  std::vector<JobRecord*> JobsOf(const std::string& worker) const;
  void Remake(JobRecord& job, const WrongWorker& wrong, Nanoseconds now);
  /// It leaves its machine, to wait for another attempt; its arm does not wait with it.
  void Requeue(JobRecord& job, const std::string& why, Nanoseconds now);
  static void NoteFirstEstimate(JobRecord& job, const TaskView& task);
  void TakePart(JobRecord& job, const TaskView& task, Nanoseconds now);
  void StageFailed(JobRecord& job, const TaskView& task, Nanoseconds now);
  void StageDone(JobRecord& job, const TaskView& task, Nanoseconds now);
  void EngraveStatus(JobRecord& job, const TaskView& task, Nanoseconds now);

  JobBook book_;
  TaskHandout tasks_;
  PieceBook pieces_;
  MountBook mounts_;
  Discretizing discretizing_{book_, tasks_};
  Arming arming_{book_, tasks_.workers(), pieces_, mounts_};
  TakeUp take_up_{book_, tasks_, arming_};
  std::vector<JobRecord*> next_;       // the first that waits for each machine,
  std::uint64_t placed_revision_ = 0;  // as of this JobBook::waiting_revision
};

}  // namespace intaglio::job_service
