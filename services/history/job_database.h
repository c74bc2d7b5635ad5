#pragma once

// Whether a file is the database of a job service, found out without changing it or
// anything beside it: before a program opens a file for writing, and before it believes
// what it reads.

#include <cstdint>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::history {

/// PRAGMA application_id of the database: "INTJ". Databases up to version 9 have none.
inline constexpr int kJobApplicationId = 1229870154;
inline constexpr int kFirstMarkedVersion = 10;
/// Newest version; services/job_service/job_migrations.h has the steps.
inline constexpr int kJobDatabaseVersion = 16;

enum class JobDatabaseKind {
  kNone,     ///< no file, an empty one, or a database without tables: it may be made here
  kOurs,     ///< of this version or an older one
  kNewer,    ///< of a newer program
  kForeign,  ///< no database, or that of another program
  kDamaged,  ///< ours, and what was stored in it would be missing
};

struct JobDatabase {
  JobDatabaseKind kind = JobDatabaseKind::kNone;
  int version = 0;
  std::string contents;  ///< of a foreign or damaged one, for people
};

/// kIo: the file cannot be read.
Result<JobDatabase> InspectJobDatabase(const std::filesystem::path& file);

/// Nothing when a program may read the file. kUnsupported: of a newer program;
/// kUnreadable: foreign or damaged; all name the file and what to do. kIo as above.
Status CheckJobDatabase(const std::filesystem::path& file);

/// The same for a job service, which writes: also kUnreadable when its log is damaged
/// (write_ahead_log.h) or, of a queue of at most kMaxCheckedBytes, when any page or index
/// of it is: a damaged index hides jobs without an error. No other program may have it
/// open.
Status CheckQueue(const std::filesystem::path& file);

/// Reading all of it takes half a second; a larger one is found damaged where it is read.
inline constexpr std::uint64_t kMaxCheckedBytes = 64u << 20;

/// kUnreadable, with the remedy. `where`: of the damage, for people.
Error DamagedQueue(const std::filesystem::path& file, const std::string& where);

}  // namespace intaglio::history
