#pragma once

#include <filesystem>
#include <memory>

#include "engrave/core/result.h"

namespace SQLite {
class Database;
class Exception;
}  // namespace SQLite

namespace intaglio::materials_db {

/// How long a call waits for another process that writes, before kTimedOut.
inline constexpr int kBusyTimeoutMs = 5000;

/// Opens the database, makes it when it is not there (with its folder), and brings it to
/// the newest version, each migration whole or not at all; several processes may do so
/// at once. Refused, and left as it is: a file that is no database or another program's
/// (kUnreadable), one of a newer version (kUnsupported).
Result<std::unique_ptr<SQLite::Database>> OpenDatabase(const std::filesystem::path& file);

/// SQLite's message as an error with the file and the remedy: kTimedOut, kIo or
/// kUnreadable.
Error ErrorFrom(const SQLite::Exception& exception, const std::filesystem::path& file);

}  // namespace intaglio::materials_db
