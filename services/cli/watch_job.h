#pragma once

#include <string>

#include "services/client/event_lines.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

/// Follows a job to its end, or to Ctrl-C, which leaves it as it is. With `events` they
/// take the standard output, and what people read goes to the standard error stream.
/// The exit code of docs/cli.md.
int WatchJob(client::JobClient& client, const std::string& uid,
             client::EventLines* events);

}  // namespace intaglio::cli
