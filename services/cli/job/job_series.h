#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "materials_db/material_store.h"
#include "services/cli/job/job_options.h"

namespace intaglio::cli {

/// A job for each row of a CSV file, from a job file (services/job/files/series.h),
/// checked as the job service checks it, with the glasses of that material base (empty:
/// the user's). Every mistake of every row is in the error, each with file and line.
Result<std::vector<JobAndMachine>> BuildSeries(const JobFlags& flags,
                                               const std::filesystem::path& table,
                                               const std::string& materials_db);

/// The job, frozen once as the job service does it, with its glass; what that refuses.
Result<JobAndMachine> CheckedAsInShop(Result<JobAndMachine> built,
                                      const materials_db::MaterialStore& materials);

/// The message with this before each of its lines.
Error Prefixed(Error error, const std::string& prefix);

}  // namespace intaglio::cli
