#pragma once

// Where a database is: a file of this computer, or postgresql://USER@HOST/DATABASE, with
// several hosts as HOST1,HOST2 ("Connection URIs" of PostgreSQL's documentation).

#include <memory>
#include <string>

#include "services/sql/connection.h"

namespace intaglio::sql {

bool IsServerAddress(const std::string& address);

/// The address for messages: a password becomes "***".
std::string WithoutPassword(const std::string& address);

/// What a person does about an error there.
std::string RemedyOf(const std::string& address, SqlError::Kind kind);

/// To write, and to read while another process writes.
std::unique_ptr<Connection> Open(const std::string& address);
std::unique_ptr<Connection> OpenToRead(const std::string& address);

}  // namespace intaglio::sql
