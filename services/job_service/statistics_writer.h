#pragma once

// statistics.json in every job's result folder: how long, how far, begin and expected end
// (JobStatistics of proto/shop.proto; docs/formats.md). Written whole at every change of
// the job's state, and while it progresses. The writing waits for the disk, so it has a
// thread of its own; a disk that refuses is logged and costs nothing else.
// Called from one thread.

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "proto/shop.pb.h"
#include "services/job_service/job_store.h"
#include "services/job_service/records/job_record.h"

namespace intaglio::job_service {

class StatisticsWriter {
 public:
  /// `store` has to outlive this. `recording`: of jobs without one in their folder.
  StatisticsWriter(JobStore& store, std::string recording);
  /// What came before is on the disk when this returns.
  ~StatisticsWriter();

  /// After the store's Keep.
  void Changed(const JobRecord& job);
  /// At most every kPeriod of a job.
  void Progressed(const JobRecord& job);
  /// Also keeps the verdict, once it is settled: by the outcome of the machine, with
  /// which this comes again, or unless `more_is_expected` of it.
  void Ended(const JobRecord& job, bool more_is_expected);

  static constexpr std::chrono::seconds kPeriod{2};

 private:
  void Write(const JobRecord& job);
  void Run(const std::stop_token& stop);

  JobStore& store_;
  std::string recording_;
  std::map<std::string, std::chrono::steady_clock::time_point> written_;  // by job
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::map<std::string, JobStatistics> waiting_;  // the newest, by job
  std::jthread thread_;
};

}  // namespace intaglio::job_service
