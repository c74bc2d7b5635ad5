#pragma once

// Engravings whose synchronizer was lost, and those that an earlier run of the job
// service left: the block is still in the machine, and the journal knows what is in it.
//
// The operator's arm counts for the machine as it was left, and nothing has happened that
// a person has to check: so the job goes on by itself. Not
//  - after a fault or an opened interlock, which the synchronizer distinguishes;
//  - when it was not armed, or asks before it goes on;
//  - when the synchronizer, or this job service, was away for longer than
//    host::kMaxAbsence, for the block may have been changed;
//  - when a person closed the shop or the cell;
//  - when JobArm::kMaxRenewals in a row made no point.
//
//   engraving --Lose--> paused, no worker --GiveToFree--> paused, with the next worker
// Used from one thread.

#include <optional>
#include <string>

#include "services/job_service/queue/arming.h"
#include "services/job_service/queue/task_handout.h"
#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::job_service {

class TakeUp {
 public:
  TakeUp(JobBook& book, TaskHandout& tasks, Arming& arming)
      : book_(book), tasks_(tasks), arming_(arming) {}

  /// A job of an earlier run that may have pulses in the glass. `arm_counts`: it was
  /// armed, and the job service was away for a short time.
  void Restore(JobRecord& job, bool arm_counts, Nanoseconds now);
  /// Its synchronizer is lost, and a point may have been made.
  void Lose(JobRecord& job, const std::string& why, Nanoseconds now);
  /// To the free synchronizer of its cell, if there is one and the job waits for it.
  void GiveToFree(JobRecord& job, Nanoseconds now);

  /// Once a turn: ends the arms over which a synchronizer, or this job service between
  /// two turns, was away for too long.
  void EndAbsences(Nanoseconds now);
  /// A person closed the cell of this synchronizer; the shop.
  void CloseCell(const std::string& synchronizer, Nanoseconds now);
  void CloseShop(Nanoseconds now);

  /// The report is about an engraving that this worker was given anew since. Topics
  /// overtake each other after a network was away: a synchronizer may report that it is
  /// ready, and get the job again, before its answer to the revocation arrives.
  bool AnswersAnOldRevocation(const TaskView& task) const;

 private:
  bool WasPausedForTooLong(Nanoseconds now);

  JobBook& book_;
  TaskHandout& tasks_;
  Arming& arming_;
  std::optional<Nanoseconds> last_turn_;
  host::AbsenceSum own_absence_;  ///< of this process
};

}  // namespace intaglio::job_service
