#pragma once

// A job as a display of the shop has it.

#include <cstdint>
#include <string>

#include "services/client/job_view.h"

namespace intaglio::cli {

/// "duck" of the machine "left".
inline client::JobView ShownJob(std::uint32_t number, intaglio_JobState state) {
  client::JobView job;
  job.uid = std::to_string(number) + "-abc";
  job.number = number;
  job.name = "duck";
  job.cell = "left";
  job.state = state;
  return job;
}

}  // namespace intaglio::cli
