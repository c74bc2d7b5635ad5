#pragma once

// The warnings of a job, from what its discretizers and its sorter have reported so far.

#include <cstddef>
#include <optional>
#include <vector>

#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"

namespace intaglio::job_service {

/// What is known of one attempt of a job.
struct AttemptOutcomes {
  std::vector<DiscretizeOutcome> parts;  ///< of the parts that are made
  std::optional<SortOutcome> sort;
};

/// `part_count`: of the attempt; what follows from the counts of all parts is left out
/// until all are made. `job` with its defaults filled in.
Warnings WarningsOf(const AttemptOutcomes& outcomes, std::size_t part_count,
                    const JobSpec& job);

}  // namespace intaglio::job_service
