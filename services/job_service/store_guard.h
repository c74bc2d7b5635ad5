#pragma once

// What the sources of JobStore share.

#include <fmt/format.h>

#include <chrono>
#include <string>

#include "services/history/job_database.h"
#include "services/job_service/job_store.h"
#include "services/platform/host/times/utc_time.h"
#include "services/sql/address.h"
#include "services/sql/connection.h"

namespace intaglio::job_service {

/// The time of a statement.
inline std::string NowUtc() { return host::UtcText(std::chrono::system_clock::now()); }

// The integers of a database are signed; all of ours fit but epochs in theory, which go
// through unchanged bit for bit.
inline std::int64_t Signed(std::uint64_t value) {
  return static_cast<std::int64_t>(value);
}

/// What the engine reports of the store at `place`, with the remedy.
inline StoreError ErrorOf(const std::string& place, const sql::SqlError& error) {
  if (error.kind() == sql::SqlError::Kind::kDamaged && !sql::IsServerAddress(place))
    return {history::DamagedQueue(place, error.what()).message, false};
  return {fmt::format("job database {}: {}; {}", sql::WithoutPassword(place),
                      error.what(), sql::RemedyOf(place, error.kind())),
          error.kind() == sql::SqlError::Kind::kPasses};
}

template <typename Body>
auto Guarded(const sql::Connection& database, Body&& body) {
  try {
    return body();
  } catch (const sql::SqlError& error) {
    throw ErrorOf(database.Place(), error);
  }
}

}  // namespace intaglio::job_service
