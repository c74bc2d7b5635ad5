#pragma once

#include <string>

#include "services/cli/event_lines.h"
#include "services/cli/job_client.h"

namespace intaglio::cli {

/// Follows a job to its end, or to Ctrl-C, which leaves it as it is. With `events` they
/// take the standard output, and what people read goes to the standard error stream.
/// The exit code of docs/cli.md.
int WatchJob(JobClient& client, const std::string& uid, EventLines* events);

}  // namespace intaglio::cli
