#pragma once

// Gives tasks to workers and revokes them, and records in worker_book.h which worker has
// which task, with every order that goes out.
//
// 1. A worker that a task is given to has it in the book before the order goes out.
// 2. Only what a worker still has is revoked, and once.
// 3. The revocation of an engraving that may be taken up again is marked so: the
//    lamp stays on.
// Used from one thread.

#include <string>
#include <vector>

#include "services/job_service/queue/worker_book.h"
#include "services/job_service/records/job_actions.h"

namespace intaglio::job_service {

class TaskHandout {
 public:
  explicit TaskHandout(JobActions& actions) : actions_(actions) {}

  WorkerBook& workers() { return workers_; }
  const WorkerBook& workers() const { return workers_; }

  /// Ordering or engraving. `consumer`: as in TaskOrder.
  void Give(const JobRecord& job, intaglio_Stage stage, const std::string& worker,
            const std::string& consumer, Nanoseconds now);
  /// An engraving that another worker began.
  void GiveTakeUp(const JobRecord& job, Nanoseconds now);
  /// To the worker that the part has.
  void GivePart(const JobRecord& job, std::uint32_t part, Nanoseconds now);
  /// The same, to be begun when what that worker is at has ended.
  void GivePartAhead(const JobRecord& job, std::uint32_t part, Nanoseconds now);
  /// The part that is compared, to the worker that makes it once more, `ahead` or not.
  void GiveComparison(const JobRecord& job, bool ahead, Nanoseconds now);

  /// Whatever the worker has.
  void Revoke(const JobRecord& job, const GivenTask& given, Nanoseconds now);
  /// Those of these that a worker still has.
  void RevokeHeld(const JobRecord& job, std::vector<GivenTask> tasks, Nanoseconds now);
  /// The same, and the feed of the job's models ends.
  void RevokeAndStopFeed(const JobRecord& job, const std::vector<GivenTask>& tasks,
                         Nanoseconds now);
  /// A part that was given ahead to a worker that is lost with all it had.
  void RevokePartAhead(const JobRecord& job, const std::string& worker,
                       const TaskId& task);
  void StopFeed(const JobRecord& job) { actions_.StopFeed(job.uid); }

  /// As in WorkerBook, and kept. Nothing changes of one that is left out for good.
  /// `kept`: the reason after a restart of the job service, which forgets comparisons.
  void LeaveOut(const std::string& worker, const std::string& why);
  void Suspect(const std::string& worker, const std::string& why,
               const std::string& kept);
  void TakeBack(const std::string& worker);
  /// By a person. False: it was neither left out nor slow.
  bool Admit(const std::string& worker, const std::string& operator_name);

  /// Workers that were lost long ago leave the book.
  void ForgetLost(Nanoseconds now);

 private:
  void SendPart(const JobRecord& job, std::uint32_t part);

  JobActions& actions_;
  WorkerBook workers_;
};

}  // namespace intaglio::job_service
