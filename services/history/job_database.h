#pragma once

// Whether a file is the database of a job service, found out without changing it or
// anything beside it: before a program opens a file for writing, and before it believes
// what it reads.

#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::history {

/// PRAGMA application_id of the database: "INTJ". Databases up to version 9 have none.
inline constexpr int kJobApplicationId = 1229870154;
inline constexpr int kFirstMarkedVersion = 10;
/// Newest version; services/job_service/job_migrations.h has the steps.
inline constexpr int kJobDatabaseVersion = 13;

enum class JobDatabaseKind {
  kNone,     ///< no file, an empty one, or a database without tables: it may be made here
  kOurs,     ///< of this version or an older one
  kNewer,    ///< of a newer program
  kForeign,  ///< no database, or that of another program
};

struct JobDatabase {
  JobDatabaseKind kind = JobDatabaseKind::kNone;
  int version = 0;
  std::string contents;  ///< of a foreign one, for people
};

/// kIo: the file cannot be read.
Result<JobDatabase> InspectJobDatabase(const std::filesystem::path& file);

/// Nothing when a job service may open the file. kUnsupported: of a newer program;
/// kUnreadable: foreign; both name the file and what to do. kIo as above.
Status CheckJobDatabase(const std::filesystem::path& file);

}  // namespace intaglio::history
