#pragma once

// What the services of a shop have logged about one job: entries of the *.log files that
// `intaglio up` and `intaglio run` leave in their folder, each "TIME SERVICE LEVEL: TEXT"
// (host/process/log.h), a line or several. Further cells have their own folders below it
// (shop_cells.h), which are read as well.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/lists.pb.h"

namespace intaglio::client {

struct LogSelection {
  /// A job's number or uid; empty: entries of no job, too.
  std::string job;
  bool warnings_only = false;    ///< of the levels warning and error
  std::size_t max_count = 1000;  ///< the newest of these
};

/// In order of time, those of equal times by the name of the file. Errors: kNotFound for
/// a folder without logs, with what to do; kIo.
Result<std::vector<std::string>> ReadLog(const std::filesystem::path& folder,
                                         const LogSelection& selection);

/// "TIME SERVICE LEVEL: TEXT" in its parts; an entry of another form is text alone.
LogEntry LogEntryOf(const std::string& entry);

}  // namespace intaglio::client
