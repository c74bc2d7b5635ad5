#include "services/history/job_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "engrave/core/try.h"
#include "services/history/write_ahead_log.h"
#include "services/sql/sqlite_connection.h"

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

bool IsDamage(const SQLite::Exception& error) {
  return sql::KindOfSqlite(error.getErrorCode()) == sql::SqlError::Kind::kDamaged;
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

SQLite::Database OpenedToRead(const fs::path& file) {
  constexpr int kBusyMs = 2000;
  if (HasContent(file.string() + "-wal"))
    return {file.string(), SQLite::OPEN_READONLY, kBusyMs};
  return {UriOf(file), SQLite::OPEN_READONLY | SQLite::OPEN_URI, kBusyMs};
}

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
  if (id == kJobApplicationId)
    return {JobDatabaseKind::kDamaged, version, "tables of it are missing"};
  const std::size_t more = tables.size() - std::min(tables.size(), kMaxNamedTables);
  tables.resize(tables.size() - more);
  return {JobDatabaseKind::kForeign, version,
          tables.empty()
              ? fmt::format("application id {}, no tables", id)
              : fmt::format("application id {}, tables {}{}", id, fmt::join(tables, ", "),
                            more > 0 ? fmt::format(" and {} more", more) : "")};
}

/// Judges a file that SQLite does not read: it may have been ours ("Database File
/// Format", chapter 1.3: the text at 0, the application id at 68, big endian).
JobDatabase Unread(const fs::path& file, const SQLite::Exception& error) {
  constexpr char kText[] = "SQLite format 3";
  std::array<unsigned char, 100> header{};
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(header.data()), header.size());
  const std::uint32_t id = std::uint32_t{header[68]} << 24 |
                           std::uint32_t{header[69]} << 16 |
                           std::uint32_t{header[70]} << 8 | std::uint32_t{header[71]};
  const bool is_sqlite = std::memcmp(header.data(), kText, sizeof kText) == 0;
  if (is_sqlite || id == static_cast<std::uint32_t>(kJobApplicationId))
    return {JobDatabaseKind::kDamaged, 0, error.what()};
  return {JobDatabaseKind::kForeign, 0, "it is no SQLite database"};
}

/// Describes a file that is missing or has no bytes. SQLite would remove a log beside it.
JobDatabase Absent(const fs::path& file) {
  if (HasContent(file.string() + "-wal")) {
    return {JobDatabaseKind::kDamaged, 0,
            fmt::format("the file is {}, and its log is there",
                        fs::exists(file) ? "empty" : "missing")};
  }
  // A job service notes beside its queue when it was last there.
  if (fs::exists(file) && HasContent(file.string() + ".seen"))
    return {JobDatabaseKind::kDamaged, 0, "the file is empty, and was in use before"};
  return {};
}

}  // namespace

Error DamagedQueue(const fs::path& file, const std::string& where) {
  return {ErrorCode::kUnreadable,
          fmt::format("the queue {} is damaged ({}): jobs that were stored would be "
                      "missing; put the newest backup in its place (intaglio restore "
                      "BACKUP --folder {} --replace), or move the file and those that "
                      "begin like it away to begin with an empty queue; nothing was "
                      "changed",
                      file.string(), where, file.parent_path().string()),
          file.string()};
}

Result<JobDatabase> InspectJobDatabase(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error))
    return JobDatabase{JobDatabaseKind::kForeign, 0, "it is a folder"};
  if (!HasContent(file)) return Absent(file);
  const NoTrace no_trace(file);
  try {
    SQLite::Database database = OpenedToRead(file);
    return Inspect(database);
  } catch (const SQLite::Exception& exception) {
    // SQLITE_ERROR: its format is unknown; the statements here are ours.
    if (IsDamage(exception) || exception.getErrorCode() == SQLITE_ERROR)
      return Unread(file, exception);
    return Fail(ErrorCode::kIo,
                fmt::format("job database {}: {}; free space on its disk, and check "
                            "that you may read the file",
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
    case JobDatabaseKind::kDamaged:
      return tl::unexpected(DamagedQueue(file, found.contents));
    case JobDatabaseKind::kForeign:
      break;
  }
  return Fail(
      ErrorCode::kUnreadable,
      fmt::format(
          "job database {} is not one of a job service ({}); give another "
          "folder with --folder, or another file with --database, or put an "
          "intact copy there if it was the queue of this shop (intaglio restore); "
          "the file was not changed",
          file.string(), found.contents),
      file.string());
}

Status CheckQueue(const fs::path& file) {
  INTAGLIO_TRY(CheckJobDatabase(file));
  INTAGLIO_TRY(CheckWriteAheadLog(file));
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error || size == 0 || size > kMaxCheckedBytes) return {};
  const NoTrace no_trace(file);
  try {
    SQLite::Database database = OpenedToRead(file);
    const std::string found =
        database.execAndGet("PRAGMA integrity_check(1)").getString();
    if (found != "ok") return tl::unexpected(DamagedQueue(file, found));
  } catch (const SQLite::Exception& exception) {
    if (IsDamage(exception)) return tl::unexpected(DamagedQueue(file, exception.what()));
    // Any other error is reported by who opens it next, with its remedy.
  }
  return {};
}

}  // namespace intaglio::history
