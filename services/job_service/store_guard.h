#pragma once

// What the sources of JobStore share.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include "services/job_service/job_store.h"

namespace intaglio::job_service {

/// The time in SQL, as host::UtcText.
inline constexpr const char* kNow = "strftime('%Y-%m-%dT%H:%M:%fZ', 'now')";

template <typename Body>
auto Guarded(const SQLite::Database& database, Body&& body) {
  try {
    return body();
  } catch (const SQLite::Exception& error) {
    throw StoreError(
        fmt::format("job database {}: {}; make room on its disk, or see to it: the "
                    "job service then goes on by itself",
                    database.getFilename(), error.what()));
  }
}

}  // namespace intaglio::job_service
