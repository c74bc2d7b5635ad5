#pragma once

// The history as a table for spreadsheets (message_csv.h): for the command line and the
// console.

#include <cstddef>
#include <string>

#include "engrave/core/result.h"
#include "services/history/job_history.h"

namespace intaglio::history {

enum class CsvRows {
  kJobs,  ///< one for each job, the fields of JobStatistics
  kDays,  ///< one for each day and machine, the fields of DayStatistics
};

/// Errors as of ReadHistory, and kTooLarge beyond `max_bytes`: no more than that is kept.
/// Precondition: CheckFilter.
Result<std::string> HistoryCsv(const std::string& database, const Filter& filter,
                               CsvRows rows, std::size_t max_bytes);

}  // namespace intaglio::history
