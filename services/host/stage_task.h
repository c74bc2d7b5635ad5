#pragma once

// What a worker of one stage (discretizer, sorter) is given, and what it makes of it.

#include <cstdint>
#include <string>

#include "engrave/core/geometry.h"
#include "proto/task.pb.h"

namespace intaglio::host {

struct StageTask {
  std::string job_uid;
  std::uint32_t attempt = 0;
  FrozenJob job;
  std::string consumer;  ///< instance that takes the points; empty: nobody does

  bool SameAs(const std::string& other_job, std::uint32_t other_attempt) const {
    return job_uid == other_job && attempt == other_attempt;
  }
};

struct StageResult {
  PointCloud cloud;      ///< what goes to the consumer, in its order
  StageOutcome outcome;  ///< what goes to the job service; elapsed_s is filled in for it
};

}  // namespace intaglio::host
