#pragma once

// The statuses of the jobs on the bus. It lives longer than a queue: while the database
// cannot be written there is no queue, and clients still see every job as it was
// published last. Used from one thread.

#include <set>
#include <string>

#include "services/job_service/job_store.h"
#include "services/job_service/queue/job_record.h"
#include "services/platform/bus/bus.h"

namespace intaglio::job_service {

class StatusBoard {
 public:
  explicit StatusBoard(bus::Bus& bus);

  /// An open job, or the answer to a submission that was refused.
  void Publish(const JobRecord& job);
  /// One that has ended, with what the database has of it.
  void PublishEnded(const JobRecord& job, const JobResult& result);
  /// Ends the DDS instance.
  void Withdraw(const std::string& job_uid, const std::string& submission_uid);
  /// Withdraws what an earlier queue has published and the present one does not have.
  void WithdrawAllBut(const std::set<std::string>& job_uids);

 private:
  void Write(const JobRecord& job, const intaglio_PointCounts& counts,
             const std::string& verdict);

  bus::Writer<intaglio_JobStatus> statuses_;
  std::set<std::pair<std::string, std::string>> published_;  // job and submission
};

}  // namespace intaglio::job_service
