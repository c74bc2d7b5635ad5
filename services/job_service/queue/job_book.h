#pragma once

// The jobs of the queue: each under its uid, the open ones in the order of their turn,
// the ended ones until they may be forgotten. Every change of a job is published through
// here, and its revision grows with each.
//
// 1. A change of state is kept (JobActions::Changed) before the call returns; a message
//    or a progress alone is published and not kept.
// 2. pause_reason is PAUSE_NONE exactly when the state is not JOB_PAUSED.
// 3. Order of the turn: higher priorities first; of equal ones in the order of
//    submission, until a person moves one. A moved job takes the priority of its new
//    neighbour.
// 4. An ended job leaves when kRememberedJobs have ended after it, kRememberedFor after
//    its end at the earliest; the database keeps it (job_store.h). References to jobs
//    last until Forget. Used from one thread.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "services/job_service/queue/ended_list.h"
#include "services/job_service/records/job_actions.h"

namespace intaglio::job_service {

/// Ended jobs that stay in memory and on the bus, the newest: what `intaglio list` shows.
inline constexpr std::size_t kRememberedJobs = 100;
/// An end stays on the bus for at least this time. A client that was stopped or cut off
/// reads it when it is back within this time; a client that comes later reads the
/// history.
inline constexpr std::chrono::seconds kRememberedFor{60};

/// Between the turns of two jobs that were submitted one after the other.
inline constexpr std::int64_t kTurnStep = std::int64_t{1} << 20;

class JobBook {
 public:
  explicit JobBook(JobActions& actions) : actions_(actions) {}

  /// A job that is open, at its place in the turn. Not published yet.
  JobRecord& Add(JobRecord job);
  /// The same of one that has no turn yet: behind the others of its priority.
  JobRecord& AddNew(JobRecord job);
  /// One that ended in an earlier run of the job service: published.
  void AddEnded(JobRecord job, Nanoseconds now);

  const JobRecord* Find(const std::string& job_uid) const;
  JobRecord* Find(const std::string& job_uid);
  /// Null for one that has ended, too.
  JobRecord* FindOpen(const std::string& job_uid);
  const std::map<std::string, JobRecord>& jobs() const { return jobs_; }
  /// By uid.
  std::map<std::string, JobRecord>& jobs() { return jobs_; }
  /// The open ones; what ends meanwhile stays valid.
  std::vector<JobRecord*> InTurn() const;
  /// Those of them that have their machine: as many as there are machines at most,
  /// however many wait. For what is done in every turn.
  std::vector<JobRecord*> ActiveInTurn() const;
  /// Grows when another job waits, or in another order.
  std::uint64_t waiting_revision() const { return waiting_revision_; }
  bool CellIsTaken(const std::string& cell) const;
  /// Why the job cannot be moved before `before_job_uid` (empty: behind all that wait for
  /// its machine), for people; empty: it can.
  std::string WhyNotMoved(const JobRecord& job, const std::string& before_job_uid) const;
  /// Moves it; only when WhyNotMoved is empty.
  void Move(JobRecord& job, const std::string& before_job_uid);

  void Change(JobRecord& job, intaglio_JobState state, const std::string& message);
  void ChangeToPaused(JobRecord& job, intaglio_PauseReason reason,
                      const std::string& message);
  /// As Change when the state differs; a message alone is published and not kept.
  void Publish(JobRecord& job, intaglio_JobState state, const std::string& message);
  void PublishProgress(JobRecord& job) { Publish(job, job.state, job.message); }
  /// As it was kept by an earlier run of the job service.
  void PublishRestored(const JobRecord& job) { actions_.Progressed(job); }
  /// An ended state. Its frozen job, up to a megabyte, is of no use any more after this.
  void End(JobRecord& job, intaglio_JobState state, const std::string& message,
           Nanoseconds now);
  /// Forgets the jobs that may be forgotten.
  void Forget(Nanoseconds now);

 private:
  /// {-priority, turn, number}.
  using Turn = std::tuple<std::int32_t, std::int64_t, std::uint32_t>;
  static Turn TurnOf(const JobRecord& job) {
    return {-job.priority, job.turn, job.number};
  }
  bool IsWaiting(const JobRecord& job, const std::string& cell) const {
    return job.state == intaglio_JOB_QUEUED && job.cell == cell;
  }
  /// The last one that waits for the cell, besides `job`; nullptr: none.
  const JobRecord* LastWaiting(const JobRecord& job) const;
  /// The turn of the one right ahead of `entry`; nullopt: none of this priority is.
  std::optional<std::int64_t> TurnAhead(std::map<Turn, JobRecord*>::const_iterator entry,
                                        std::int32_t priority) const;
  /// A turn right before that of `next`, at its priority; makes room where there is none.
  std::int64_t TurnBefore(const JobRecord& next);
  /// Gives the jobs of a priority turns that are kTurnStep apart, in their order.
  void SpreadTurns(std::int32_t priority);

  /// Its state is another one, or it is new.
  void NoteState(JobRecord& job, intaglio_JobState before);

  JobActions& actions_;
  std::map<std::string, JobRecord> jobs_;  // by uid
  // Those that ended leave with the next Forget.
  std::map<Turn, JobRecord*> in_turn_;
  std::set<JobRecord*> active_;
  std::uint64_t waiting_revision_ = 1;
  bool has_ended_ = false;  // one that is in in_turn_
  EndedList ended_{kRememberedJobs, kRememberedFor};
};

}  // namespace intaglio::job_service
