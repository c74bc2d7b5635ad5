#pragma once

// How the parts of the console ask for a job's files (services/console/job_finder.h).

#include <functional>
#include <string>

#include "engrave/core/result.h"
#include "services/history/job_history.h"

namespace intaglio::console {

using FoundJob = history::JobFolder;
/// Finds a job, and calls `found` in a turn of the desk. kNotFound, and what reading the
/// database fails with; kRefused: too many files are asked for.
using FindJob =
    std::function<void(std::string job, std::function<void(Result<FoundJob>)> found)>;

}  // namespace intaglio::console
