#pragma once

// The operator's side of the queue: commands, emergency stops, and the permission of
// every cell, which follows from the arms of its job (job_arm.h).
//
// 1. A person arms a job for the block that is in the machine: only a job that has its
//    cell can be armed.
// 2. An ARM or RESUME that was sent before a pause, stop or disarming has no effect, in
//    whatever order they arrive (disarm_count).
// 3. Nothing is granted in a cell whose emergency stop is pressed, and nothing is armed
//    there anew; a reset arms nothing.
// 4. A permission is granted only to the synchronizer that has the job's task; a job's
//    first grant is kept before it is handed out.
// 5. A job with a warning that a person has to accept is armed only with that consent;
//    an arm from before the warning was known ends with it.
// 6. A program's arm counts only after the machine was opened (cells/piece_book.h).
// 7. A job is armed only for what is mounted in its machine (cells/mount_book.h), and a
//    person who says that something was mounted ends the arms there.
// 8. A job is not armed while a discretizer that made a part of it is suspected
//    (comparing.h).
// Used from one thread.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "services/job_service/cells/mount_book.h"
#include "services/job_service/cells/piece_book.h"
#include "services/job_service/queue/job_book.h"
#include "services/job_service/queue/worker_book.h"

namespace intaglio::job_service {

class Arming {
 public:
  /// All outlive this.
  Arming(JobBook& book, const WorkerBook& workers, PieceBook& pieces, MountBook& mounts)
      : book_(book), workers_(workers), pieces_(pieces), mounts_(mounts) {}

  /// Whether the command is allowed; else why not. Changes nothing.
  CommandAnswer Check(const JobRecord& job, const CommandView& command) const;
  void Arm(JobRecord& job, const CommandView& command, Nanoseconds now);
  void Pause(JobRecord& job, const CommandView& command, Nanoseconds now);

  /// An emergency stop is pressed in that cell, or not any more. It disarms also a job
  /// that is not armed: an ARM may be on its way.
  void SetStop(const std::string& cell, bool pressed, Nanoseconds now);
  bool IsStopped(const std::string& cell) const { return stopped_cells_.contains(cell); }

  /// New warnings of a job: an arm without the consent that they need ends.
  void TakeWarnings(JobRecord& job, const Warnings& warnings, Nanoseconds now);
  /// What a job that waits for a consent asks for, for people.
  static std::string ConsentMessage(const JobRecord& job, const Warning& warning);

  /// A person has reported what is mounted, or a program with another content (rule 3 of
  /// mount_book.h).
  void SetMount(const MountRecord& mount, intaglio_ArmBasis basis, Nanoseconds now);
  /// Why the job may not be armed for what is mounted; empty: it may.
  const std::string& MountMisfitOf(JobRecord& job) const;
  /// Publishes of every job with a machine whether it awaits another block.
  void TurnPieces();

  /// After a loss: arms the job as it was armed, a while later, unless something forbids
  /// it (JobArm::Renew).
  void Renew(JobRecord& job, Nanoseconds now);
  /// An engraving task is paused: a fault spends the arm; after a lost line the arm is
  /// renewed.
  void TakePaused(JobRecord& job, const TaskView& task, Nanoseconds now);

  /// Why the arm of a job ends, for people; empty: it does not.
  using WhyItEnds = std::function<std::string(const JobRecord& job)>;
  /// Ends the arm of every job; `reason` is that of those that are paused by it.
  void EndArms(intaglio_PauseReason reason, Nanoseconds now, const WhyItEnds& why);

  /// For every cell that has a job.
  std::vector<PermissionView> Permissions(Nanoseconds now);

 private:
  void NoteReset(const std::string& cell, const std::string& reason);
  CommandAnswer CheckArm(const JobRecord& job, const CommandView& command) const;
  void EndArm(JobRecord& job, intaglio_PauseReason reason, const std::string& why,
              Nanoseconds now);
  /// Its arm was spent before it had a path.
  void SpendBeforePath(JobRecord& job, const TaskView& task, Nanoseconds now);

  JobBook& book_;
  const WorkerBook& workers_;
  PieceBook& pieces_;
  MountBook& mounts_;
  std::set<std::string> stopped_cells_;
};

}  // namespace intaglio::job_service
