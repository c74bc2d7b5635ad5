#pragma once

#include <string>

#include "idl/job.h"

namespace intaglio::job_service {

/// The result of a job that has ended.
struct JobResult {
  std::string verdict;  ///< VerdictName; empty: not settled yet
  intaglio_PointCounts counts{};
};

}  // namespace intaglio::job_service
