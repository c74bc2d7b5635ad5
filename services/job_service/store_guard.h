#pragma once

// What the sources of JobStore share.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <string>

#include "services/history/job_database.h"
#include "services/job_service/job_store.h"

namespace intaglio::job_service {

/// The time in SQL, as host::UtcText.
inline constexpr const char* kNow = "strftime('%Y-%m-%dT%H:%M:%fZ', 'now')";

// SQLite's integers are signed; all of ours fit but epochs in theory, which go through
// unchanged bit for bit.
inline std::int64_t Signed(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

/// What SQLite reports of the file, with the remedy.
inline StoreError ErrorOf(const std::string& file, const SQLite::Exception& error) {
  if (history::IsDamage(error.getErrorCode()))
    return {history::DamagedQueue(file, error.what()).message, false};
  constexpr int kPrimary = 0xff;  // an extended code has it in its lowest byte
  switch (error.getErrorCode() & kPrimary) {
    case SQLITE_FULL:
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_NOMEM:
      return {
          fmt::format(
              "job database {}: {}; free space on its disk, and check that its folder "
              "exists and may be written: the job service then continues automatically",
              file, error.what()),
          true};
    default:
      return {fmt::format("job database {}: {}; give another file with --database, or "
                          "replace it by an intact copy",
                          file, error.what()),
              false};
  }
}

template <typename Body>
auto Guarded(const SQLite::Database& database, Body&& body) {
  try {
    return body();
  } catch (const SQLite::Exception& error) {
    throw ErrorOf(database.getFilename(), error);
  }
}

}  // namespace intaglio::job_service
