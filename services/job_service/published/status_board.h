#pragma once

// The statuses of the jobs on the bus, how many jobs have one (JobCount), and what is
// mounted in the machines. It lives
// longer than a queue: while the database cannot be written there is no queue, and
// clients still see every job as it was published last.
//
// The count grows before the first status of a job is written, and falls after the last
// one is disposed: a reader with as many jobs as the count has received all. Used from
// one thread.

#include <set>
#include <string>

#include "services/job_service/records/job_record.h"
#include "services/job_service/records/job_result.h"
#include "services/platform/bus/bus.h"

namespace intaglio::job_service {

class StatusBoard {
 public:
  /// `instance`: of the process, as in its health.
  StatusBoard(bus::Bus& bus, std::string instance);

  /// Before the first status of a queue: the jobs that it publishes at once. The first
  /// count comes with this call; until then no reader takes what it has for all.
  void Announce(const std::set<std::string>& job_uids);

  /// An open job, or the answer to a submission that was refused.
  void Publish(const JobRecord& job);
  /// One that has ended, with what the database has of it.
  void PublishEnded(const JobRecord& job, const JobResult& result);
  void Publish(const MountRecord& mount);
  /// Ends the DDS instance.
  void Withdraw(const std::string& job_uid, const std::string& submission_uid);
  /// Withdraws what an earlier queue has published and the present one does not have.
  void WithdrawAllBut(const std::set<std::string>& job_uids);

 private:
  void Write(const JobRecord& job, const intaglio_PointCounts& counts,
             const std::string& verdict);
  void WriteCount();

  std::string instance_;
  bus::Writer<intaglio_JobStatus> statuses_;
  bus::Writer<intaglio_JobCount> counts_;
  std::set<std::string> counted_;  // uids of jobs
  bus::Writer<intaglio_CellMount> mounts_;
  std::set<std::pair<std::string, std::string>> published_;  // job and submission
};

}  // namespace intaglio::job_service
