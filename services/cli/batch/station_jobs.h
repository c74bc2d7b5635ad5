#pragma once

// The jobs of one loading: the same piece at several stations of the machine's table, a
// job for each.

#include <cstdint>
#include <string>
#include <vector>

#include "services/cli/job/job_options.h"

namespace intaglio::cli {

/// "1,2,4": station numbers, 1..64, each once. kInvalidValue.
Result<std::vector<std::uint32_t>> ParseStations(const std::string& text);

/// As BuildJobToEngrave, once for each station, its number behind the job's name. Every
/// mistake is in the error; notes and warnings are in the first job alone.
Result<std::vector<JobAndMachine>> BuildStationJobs(
    const JobFlags& flags, const std::vector<std::uint32_t>& stations);

}  // namespace intaglio::cli
