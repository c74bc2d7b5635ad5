#pragma once

#include <chrono>
#include <string>

#include "services/client/job_client.h"

namespace intaglio::client {

/// A job service that is there sends its jobs within this time, on a computer that is not
/// busy (patience.h).
inline constexpr std::chrono::seconds kJobsWithin{10};

/// Polls until a job service is seen; false when none is within `time` (patience.h).
bool PollUntilServed(JobClient& client, std::chrono::milliseconds time);

/// Polls until all jobs of a shop are known (JobClient::KnowsAllJobs). kTimedOut: there
/// is no job service within `discovery_time`. kLinkLost: it has not sent all of its jobs
/// within `jobs_within`, and how many are missing. kFault: it cannot read its queue.
Status PollUntilJobsAreKnown(JobClient& client, std::chrono::milliseconds discovery_time,
                             std::chrono::milliseconds jobs_within = kJobsWithin);

/// A job of the shop by its uid or number, once it has come. kNotFound when all jobs are
/// known and it is none of them; else as PollUntilJobsAreKnown.
Result<JobView> AwaitJob(JobClient& client, const std::string& uid_or_number,
                         std::chrono::milliseconds discovery_time);

}  // namespace intaglio::client
