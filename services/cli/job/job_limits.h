#pragma once

// The bounds on the files of the job that a command is given.

#include "services/cli/flags/job_flags.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {

/// With the reader of its meshes.
ReadLimits LimitsOf(const JobFlags& flags);

}  // namespace intaglio::cli
