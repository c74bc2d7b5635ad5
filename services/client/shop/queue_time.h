#pragma once

// How long each machine takes for its open jobs, by their pace and their plans: the one
// computation, for `list`, the console's page and programs.

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "proto/listing.pb.h"
#include "services/client/job_view.h"

namespace intaglio::client {

/// The time of the machine that an open job takes yet, s; 0: not known. Of a job that is
/// engraved by its pace, else by its plan. Preparing its points, the wait for an arm and
/// pauses are not in it: what a person decides has no time.
double MachineSecondsLeft(const JobView& job);

/// By the name of the machine; those without an open job are left out.
std::vector<QueueTime> QueueTimesOf(const std::vector<JobView>& jobs,
                                    std::chrono::system_clock::time_point now);

}  // namespace intaglio::client
