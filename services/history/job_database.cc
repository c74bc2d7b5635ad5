#include "services/history/job_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "engrave/core/try.h"

// SQLite opens a file without any trace as `immutable`: it makes no lock, no -shm and no
// -wal, and reads the main file alone. That is the whole database unless a program that
// was killed, or one that still runs, has left a -wal; then it is read with it, which
// takes a -shm that is removed again if it was not there.

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;

constexpr std::array kTables = {"runs", "jobs", "submissions", "stages", "tasks"};
constexpr std::size_t kMaxNamedTables = 5;

std::string UriOf(const fs::path& file) {
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?mode=ro&immutable=1";
}

bool HasContent(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  return !error && size > 0;
}

/// Removes a -shm that reading has made.
class NoTrace {
 public:
  explicit NoTrace(const fs::path& file)
      : shm_(file.string() + "-shm"), was_there_(fs::exists(shm_)) {}
  ~NoTrace() {
    std::error_code ignored;
    if (!was_there_) fs::remove(shm_, ignored);
  }
  NoTrace(const NoTrace&) = delete;
  NoTrace& operator=(const NoTrace&) = delete;

 private:
  fs::path shm_;
  bool was_there_;
};

JobDatabase Inspect(SQLite::Database& database) {
  const int id = database.execAndGet("PRAGMA application_id").getInt();
  const int version = database.execAndGet("PRAGMA user_version").getInt();
  std::vector<std::string> tables;
  SQLite::Statement select(database,
                           "SELECT name FROM sqlite_master WHERE type = 'table' "
                           "AND name NOT LIKE 'sqlite_%' ORDER BY name");
  while (select.executeStep()) tables.push_back(select.getColumn(0).getString());
  if (tables.empty() && id == 0 && version == 0) return {};
  const bool has_tables = std::all_of(kTables.begin(), kTables.end(), [&](const char* t) {
    return std::find(tables.begin(), tables.end(), t) != tables.end();
  });
  const bool unmarked = id == 0 && version > 0 && version < kFirstMarkedVersion;
  if (has_tables && (id == kJobApplicationId || unmarked)) {
    return {
        version > kJobDatabaseVersion ? JobDatabaseKind::kNewer : JobDatabaseKind::kOurs,
        version,
        {}};
  }
  // A newer program may have other tables.
  if (id == kJobApplicationId && version > kJobDatabaseVersion)
    return {JobDatabaseKind::kNewer, version, {}};
  const std::size_t more = tables.size() - std::min(tables.size(), kMaxNamedTables);
  tables.resize(tables.size() - more);
  return {JobDatabaseKind::kForeign, version,
          tables.empty()
              ? fmt::format("application id {}, no tables", id)
              : fmt::format("application id {}, tables {}{}", id, fmt::join(tables, ", "),
                            more > 0 ? fmt::format(" and {} more", more) : "")};
}

bool IsNoDatabase(const SQLite::Exception& error) {
  return error.getErrorCode() == SQLITE_NOTADB || error.getErrorCode() == SQLITE_CORRUPT;
}

}  // namespace

Result<JobDatabase> InspectJobDatabase(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    return JobDatabase{JobDatabaseKind::kForeign, 0, "it is a folder"};
  if (!HasContent(file)) return JobDatabase{};
  const NoTrace no_trace(file);
  try {
    const bool has_log = HasContent(file.string() + "-wal");
    SQLite::Database database(
        has_log ? file.string() : UriOf(file),
        has_log ? SQLite::OPEN_READONLY : SQLite::OPEN_READONLY | SQLite::OPEN_URI, 2000);
    return Inspect(database);
  } catch (const SQLite::Exception& exception) {
    if (IsNoDatabase(exception))
      return JobDatabase{JobDatabaseKind::kForeign, 0, "it is no SQLite database"};
    return Fail(ErrorCode::kIo,
                fmt::format("job database {}: {}; check that you may read the file and "
                            "that its disk has room",
                            file.string(), exception.what()),
                file.string());
  }
}

Status CheckJobDatabase(const fs::path& file) {
  const JobDatabase found = INTAGLIO_TRY(InspectJobDatabase(file));
  switch (found.kind) {
    case JobDatabaseKind::kNone:
    case JobDatabaseKind::kOurs:
      return {};
    case JobDatabaseKind::kNewer:
      return Fail(ErrorCode::kUnsupported,
                  fmt::format("job database {} has version {}, this program supports {}; "
                              "use the newer program; the file was not changed",
                              file.string(), found.version, kJobDatabaseVersion),
                  file.string());
    case JobDatabaseKind::kForeign:
      break;
  }
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format("job database {} is not one of a job service ({}); give another "
                  "folder with --folder, or another file with --database; the "
                  "file was not changed",
                  file.string(), found.contents),
      file.string());
}

}  // namespace intaglio::history
