#include "services/sql/address.h"

#include "services/sql/postgres_connection.h"
#include "services/sql/sqlite_connection.h"

namespace intaglio::sql {

bool IsServerAddress(const std::string& address) {
  return address.starts_with("postgresql://") || address.starts_with("postgres://");
}

std::string WithoutPassword(const std::string& address) {
  const auto user = address.find("://");
  const auto host = address.find('@');
  if (user == std::string::npos || host == std::string::npos) return address;
  const auto password = address.find(':', user + 3);
  if (password == std::string::npos || password > host) return address;
  return address.substr(0, password + 1) + "***" + address.substr(host);
}

std::string RemedyOf(const std::string& address, SqlError::Kind kind) {
  const bool passes = kind == SqlError::Kind::kPasses;
  if (IsServerAddress(address)) {
    return passes
               ? "check that its server runs, can be reached and has room on its disk: "
                 "the job service then continues automatically"
               : "give another database with --database, or restore its newest dump";
  }
  return passes ? "free space on its disk, and check that its folder exists and may be "
                  "written: the job service then continues automatically"
                : "give another file with --database, or replace it by an intact copy";
}

std::unique_ptr<Connection> Open(const std::string& address) {
  return IsServerAddress(address) ? OpenPostgres(address) : OpenSqlite(address);
}

std::unique_ptr<Connection> OpenToRead(const std::string& address) {
  return IsServerAddress(address) ? OpenPostgresToRead(address)
                                  : OpenSqliteToRead(address);
}

}  // namespace intaglio::sql
