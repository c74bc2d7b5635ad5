#pragma once

#include <string>

#include "services/client/event_lines.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

/// What a person has to know of the job now: what is to be done (client/job_need.h), else
/// what it waits for, with the estimate before it, the alarm and the speed behind it.
std::string NoteOf(const client::JobView& job);

/// Follows a job to its end, or to Ctrl-C, which leaves it as it is. With `events` they
/// take the standard output, and what people read goes to the standard error stream.
/// The exit code of docs/cli.md.
int WatchJob(client::JobClient& client, const std::string& uid,
             client::EventLines* events);

}  // namespace intaglio::cli
