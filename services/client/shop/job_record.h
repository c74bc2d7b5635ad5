#pragma once

#include <chrono>
#include <map>
#include <string>

#include "proto/listing.pb.h"
#include "services/client/job_client.h"

namespace intaglio::client {

/// A job of a shop for programs.
JobRecord JobRecordOf(const JobView& job);

/// By number, and how long the machines take for what is open.
JobList JobListOf(const std::map<std::string, JobView>& jobs,
                  std::chrono::system_clock::time_point now);

}  // namespace intaglio::client
