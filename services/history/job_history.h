#pragma once

// What became of the jobs of a shop, as the job service's database records it
// (services/job_service/job_migrations.h, from version kHistoryVersion on). Read-only,
// and while the job service writes: it keeps a write-ahead log.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/shop.pb.h"

namespace intaglio::sql {
class Connection;
}

namespace intaglio::history {

/// The first version of the database (PRAGMA user_version) that has what is asked here.
inline constexpr int kHistoryVersion = 3;

/// An empty field does not restrict the result.
struct Filter {
  /// When the job ended, UTC: "2026-11-21", or with a time behind it, "2026-11-21T15:30".
  /// Both ends are included: until a day is until its end.
  std::string since{}, until{};
  std::string piece{};  ///< part of the job's name, in any case
  std::string material{}, verdict{}, cell{};
  std::optional<std::uint32_t> job{};  ///< short number, also of a job that has not ended
};

/// kInvalidValue when a time or a verdict is none, with what is expected.
Status CheckFilter(const Filter& filter);

/// `database`: an address of services/sql/address.h, a file or a server.
/// Jobs that have ended, oldest end first; kNotFound, kIo or kUnreadable with the remedy.
/// Precondition: CheckFilter.
Result<std::vector<JobStatistics>> ReadHistory(const std::string& database,
                                               const Filter& filter);

/// The same, one after the other; ends with the first error of `visit`.
Status VisitHistory(const std::string& database, const Filter& filter,
                    const std::function<Status(const JobStatistics&)>& visit);

/// What became of the discretizers and sorters, oldest first; nothing before
/// kWorkersVersion of the database. Errors as of ReadHistory.
Result<WorkerHistory> ReadWorkerHistory(const std::string& database);

/// A job as it was made, every default filled in, by its uid or short number. Errors as
/// above, and kNotFound for a job that is none of this shop's.
Result<JobSpec> ReadJob(const std::string& database, const std::string& uid_or_number);

/// Where the files of a job are: on the computer of the job service.
struct JobFolder {
  std::uint32_t number = 0;  ///< short
  std::filesystem::path folder;
};
/// Errors as of ReadJob.
Result<JobFolder> FindJobFolder(const std::string& database,
                                const std::string& uid_or_number);

/// As ReadHistory, from an open database; throws sql::SqlError. `now` is for the
/// progress and the expected end of a job that is engraved.
std::vector<JobStatistics> SelectJobs(sql::Connection& database, const Filter& filter,
                                      std::chrono::system_clock::time_point now);

/// How good the first estimates were, over the jobs that can be compared.
struct EstimateScore {
  std::size_t jobs = 0;
  double median_ratio = 0, min_ratio = 0, max_ratio = 0;  ///< of estimate and outcome
};
EstimateScore ScoreOf(const std::vector<JobStatistics>& jobs);

/// What a job that is engraved has come to: `done` of `total` points in `worked_s`, in
/// which no pause counts; 0: not known, and the plan decides.
void AddProgress(JobStatistics& job, std::uint64_t done, std::uint64_t total,
                 double worked_s, std::chrono::system_clock::time_point now);

}  // namespace intaglio::history
