#pragma once

// A database on a server: PostgreSQL, by libpq. Everything lies in a schema of its own,
// `intaglio`, so that a database may hold other tables as well.
//
// A process that hangs or a computer that is cut off loses the store within
// kLostAfterSeconds: the server sees that nobody answers it, and ends the session and the
// ownership with it. The owner notices in the same time, because each of its statements
// waits no longer.

#include <memory>
#include <string>

#include "services/sql/connection.h"

namespace intaglio::sql {

/// From the last answer until both sides give a connection up, with the figures below.
inline constexpr int kLostAfterSeconds = 5;

/// Takes, of several hosts of one address, the one that may be written. The schema is
/// made by whoever owns the store (TryOwn).
std::unique_ptr<Connection> OpenPostgres(const std::string& address);
/// Takes any host, to read.
std::unique_ptr<Connection> OpenPostgresToRead(const std::string& address);

/// A statement and a script of connection.h in the words of PostgreSQL.
std::string PostgresStatement(const std::string& sql);
std::string PostgresScript(const std::string& script);

/// A text as the server takes it: what is no UTF-8, and the zero byte, become U+FFFD.
std::string ValidUtf8(std::string_view text);

}  // namespace intaglio::sql
