#pragma once

// A database in a file: SQLite.

#include <filesystem>
#include <memory>

#include "services/sql/connection.h"

namespace intaglio::sql {

/// To write: the file is made when there is none, its folder is not. A commit is on the
/// disk when it returns.
std::unique_ptr<Connection> OpenSqlite(const std::filesystem::path& file);

/// To read, while another process may write.
std::unique_ptr<Connection> OpenSqliteToRead(const std::filesystem::path& file);

/// The kind of an error of SQLite, by its result code.
SqlError::Kind KindOfSqlite(int result_code);

}  // namespace intaglio::sql
