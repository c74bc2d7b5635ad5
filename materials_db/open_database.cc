#include "materials_db/open_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <system_error>

#include "engrave/core/try.h"
#include "materials_db/migrations.h"

namespace intaglio::materials_db {
namespace {

constexpr int kApplicationId = 1229870157;  // as in migrations/001_schema.sql

int Pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(fmt::format("PRAGMA {}", name)).getInt();
}

/// Whether the file may be brought to the newest version.
Status CheckOwner(SQLite::Database& database, const std::filesystem::path& file) {
  const int version = Pragma(database, "user_version");
  const int newest = static_cast<int>(Migrations().size());
  const bool is_empty =
      database.execAndGet("SELECT count(*) FROM sqlite_master").getInt() == 0;
  const bool is_ours = Pragma(database, "application_id") == kApplicationId;
  if (!is_ours && !(is_empty && version == 0)) {
    return Fail(
        ErrorCode::kUnreadable,
        fmt::format("{}: this database is not one of materials; give another file",
                    file.string()),
        file.string());
  }
  if (version > newest) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: the database of materials has version {}, this program supports "
                    "versions up to {}; use a newer intaglio or another file",
                    file.string(), version, newest),
        std::to_string(version));
  }
  return {};
}

Status Migrate(SQLite::Database& database, const std::filesystem::path& file) {
  INTAGLIO_TRY(CheckOwner(database, file));
  const auto migrations = Migrations();
  const auto newest = static_cast<int>(migrations.size());
  while (Pragma(database, "user_version") < newest) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    // Another process may have migrated while this one waited for the lock.
    INTAGLIO_TRY(CheckOwner(database, file));
    const int version = Pragma(database, "user_version");
    if (version < newest) {
      database.exec(migrations[static_cast<std::size_t>(version)].sql);
      database.exec(fmt::format("PRAGMA user_version = {}", version + 1));
    }
    transaction.commit();
  }
  return {};
}

Status MakeFolder(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  if (file == ":memory:" || folder.empty()) return {};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return Fail(ErrorCode::kIo,
              fmt::format("{}: the folder of the database of materials cannot be made: "
                          "{}; name another file with INTAGLIO_MATERIALS_DB",
                          folder.string(), error.message()),
              folder.string());
}

}  // namespace

Error ErrorFrom(const SQLite::Exception& exception, const std::filesystem::path& file) {
  const auto make = [&](ErrorCode code, std::string_view remedy) {
    return Error{code, fmt::format("{}: {}; {}", file.string(), exception.what(), remedy),
                 file.string()};
  };
  switch (exception.getErrorCode()) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return make(ErrorCode::kTimedOut, "another program is writing to it, try again");
    case SQLITE_NOTADB:
      return make(ErrorCode::kUnreadable,
                  "this is not a database of materials, give another file");
    case SQLITE_CORRUPT:
      return make(ErrorCode::kUnreadable,
                  "the database is damaged, restore a copy or move it away");
    case SQLITE_FULL:
      return make(ErrorCode::kIo, "free space on the disk");
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return make(ErrorCode::kIo,
                  "check that you may write to the file and to its folder");
    default:
      return make(ErrorCode::kIo, "check the file and the disk");
  }
}

Result<std::unique_ptr<SQLite::Database>> OpenDatabase(
    const std::filesystem::path& file) {
  INTAGLIO_TRY(MakeFolder(file));
  try {
    auto database = std::make_unique<SQLite::Database>(
        file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kBusyTimeoutMs);
    INTAGLIO_TRY(Migrate(*database, file));
    return database;
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(ErrorFrom(exception, file));
  }
}

}  // namespace intaglio::materials_db
