#pragma once

#include <chrono>

#include "services/client/job_client.h"

namespace intaglio::client {

/// Polls until the jobs of a shop are known: the job service is there, which sends all
/// that it has at once, and no further job has come for `quiet`. False when the time is
/// up first: there is no job service then, or jobs come and come.
bool PollUntilJobsAreKnown(JobClient& client, std::chrono::milliseconds quiet,
                           std::chrono::milliseconds timeout);

}  // namespace intaglio::client
