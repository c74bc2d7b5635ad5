#pragma once

#include "proto/listing.pb.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

/// A job of a shop for programs.
JobRecord JobRecordOf(const client::JobView& job);

/// By number.
JobList JobListOf(const std::map<std::string, client::JobView>& jobs);

}  // namespace intaglio::cli
