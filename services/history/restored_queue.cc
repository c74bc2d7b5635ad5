#include "services/history/restored_queue.h"

#include <SQLiteCpp/Backup.h>
#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include "idl/job.h"
#include "proto/task.pb.h"
#include "services/sql/sqlite_connection.h"

namespace intaglio::history {
namespace {

namespace fs = std::filesystem;

constexpr int kArmedVersion = 4;  // of the database: from it on jobs are armed

std::string Moved(const std::string& folder, const RestoredQueue& restored) {
  const std::string from = restored.old_results + "/";
  if (restored.old_results.empty() || !folder.starts_with(from)) return folder;
  return restored.new_results + "/" + folder.substr(from.size());
}

void MoveFolders(SQLite::Database& database, const RestoredQueue& restored) {
  SQLite::Statement select(
      database, "SELECT number, result_directory, frozen_job, report FROM jobs");
  SQLite::Statement update(database,
                           "UPDATE jobs SET result_directory = ?, frozen_job = ?, report "
                           "= ? WHERE number = ?");
  while (select.executeStep()) {
    std::string bytes = select.getColumn(2).getString();
    FrozenJob frozen;
    if (frozen.ParseFromString(bytes)) {
      frozen.set_result_directory(Moved(frozen.result_directory(), restored));
      bytes = frozen.SerializeAsString();
    }
    update.bind(1, Moved(select.getColumn(1).getString(), restored));
    update.bind(2, bytes.data(), static_cast<int>(bytes.size()));
    update.bind(3, Moved(select.getColumn(3).getString(), restored));
    update.bind(4, select.getColumn(0).getInt64());
    update.exec();
    update.reset();
  }
}

void EndBegun(SQLite::Database& database, const RestoredQueue& restored) {
  SQLite::Statement end(database,
                        "UPDATE jobs SET state = ?, ended = 1, pause_reason = 0, message "
                        "= ?, verdict = '', "
                        "changed_utc = strftime('%Y-%m-%dT%H:%M:%fZ', 'now'), "
                        "ended_utc = strftime('%Y-%m-%dT%H:%M:%fZ', 'now') "
                        "WHERE ended = 0 AND ever_granted = 1");
  end.bind(1, static_cast<int>(intaglio_JOB_FAILED));
  end.bind(2, fmt::format("restored from the backup of {}: what was made after it is "
                          "unknown; make the piece anew (intaglio again) in a new block",
                          restored.made_utc));
  end.exec();
}

Error ErrorOf(const fs::path& file, const SQLite::Exception& exception) {
  if (sql::KindOfSqlite(exception.getErrorCode()) == sql::SqlError::Kind::kDamaged) {
    return {ErrorCode::kUnreadable,
            fmt::format("{} is damaged: {}; put an intact copy in its place",
                        file.string(), exception.what()),
            file.string()};
  }
  return {ErrorCode::kIo,
          fmt::format("{}: {}; check that the file may be read, and that its disk has "
                      "room",
                      file.string(), exception.what()),
          file.string()};
}

/// Who has a lock on these bytes; 0: nobody.
int LockerOf(const fs::path& file, off_t begin, off_t size) {
  const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return 0;
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = begin;
  lock.l_len = size;
  const bool asked = fcntl(fd, F_GETLK, &lock) == 0;
  close(fd);
  return asked && lock.l_type != F_UNLCK ? lock.l_pid : 0;
}

}  // namespace

Status AdaptRestoredQueue(const fs::path& database, const RestoredQueue& restored) {
  try {
    SQLite::Database open(database.string(), SQLite::OPEN_READWRITE, 2000);
    SQLite::Transaction transaction(open);
    if (restored.old_results != restored.new_results) MoveFolders(open, restored);
    if (open.execAndGet("PRAGMA user_version").getInt() >= kArmedVersion) {
      open.exec("UPDATE jobs SET armed = 0, asks_before_resume = 1 WHERE ended = 0");
      if (restored.ends_begun) EndBegun(open, restored);
    }
    transaction.commit();
    open.exec("PRAGMA journal_mode = DELETE");  // all of it is in the file
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(ErrorOf(database, exception));
  }
  return {};
}

int ProcessWith(const fs::path& database) {
  // "Database File Format", chapter 1.4: the shared locks. "Write-Ahead Log", the -shm:
  // a connection holds a shared lock on byte 128 of it.
  constexpr off_t kSharedFirst = 0x40000002, kSharedBytes = 510, kShmByte = 128;
  const int reader = LockerOf(database, kSharedFirst, kSharedBytes);
  return reader != 0 ? reader : LockerOf(database.string() + "-shm", kShmByte, 1);
}

Status CopyDatabase(const fs::path& from, const fs::path& to) {
  try {
    SQLite::Database source(from.string(), SQLite::OPEN_READONLY, 2000);
    SQLite::Database copy(to.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, 0);
    SQLite::Backup backup(copy, source);
    constexpr int kTries = 100, kBetweenMs = 20;
    int state = SQLITE_BUSY;
    for (int i = 0; i < kTries && state != SQLITE_DONE; ++i) {
      state = backup.executeStep(-1);
      if (state != SQLITE_DONE) sqlite3_sleep(kBetweenMs);
    }
    if (state != SQLITE_DONE)
      throw SQLite::Exception("it is written without a pause", SQLITE_BUSY);
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(ErrorOf(from, exception));
  }
  try {
    SQLite::Database copy(to.string(), SQLite::OPEN_READWRITE, 0);
    copy.exec("PRAGMA journal_mode = DELETE");
    const std::string found = copy.execAndGet("PRAGMA integrity_check(1)").getString();
    if (found != "ok") throw SQLite::Exception(found, SQLITE_CORRUPT);
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(ErrorOf(from, exception));
  }
  return {};
}

}  // namespace intaglio::history
