#pragma once

#include "proto/listing.pb.h"
#include "services/client/job_client.h"

namespace intaglio::client {

/// A job of a shop for programs.
JobRecord JobRecordOf(const JobView& job);

/// By number.
JobList JobListOf(const std::map<std::string, JobView>& jobs);

}  // namespace intaglio::client
