#pragma once

// How the parts of the console ask for a job's files (services/console/job_finder.h).

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::console {

struct FoundJob {
  std::uint32_t number = 0;  ///< short
  std::filesystem::path folder;
};
/// Finds a job, and calls `found` in a turn of the desk. kNotFound, and what reading the
/// database fails with; kRefused: too many files are asked for.
using FindJob =
    std::function<void(std::string job, std::function<void(Result<FoundJob>)> found)>;

}  // namespace intaglio::console
