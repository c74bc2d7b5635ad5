#pragma once

// The job that a person names to look at it before it is engraved.

#include <string>

#include "engrave/core/result.h"
#include "services/cli/flags/job_flags.h"
#include "services/cli/job/job_options.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// Where the number of a job is looked up.
struct ShopOfJob {
  std::string folder = "intaglio-shop", database;
};

/// --folder and --database.
void AddShopOfJob(command_line::Command command, ShopOfJob& shop);

/// `flags.what`: a job file or models, each with the options, or the number or uid of a
/// job of the shop. Errors as of BuildJob and of history::ReadJob.
Result<JobAndMachine> FindNamedJob(const JobFlags& flags, const ShopOfJob& shop);

}  // namespace intaglio::cli
