#pragma once

// The task of a worker of one stage (discretizer, sorter), and its result.

#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/mark/mark.h"
#include "proto/task.pb.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

struct StageTask {
  std::string job_uid;
  std::uint32_t attempt = 0;
  TaskPart part;
  std::uint32_t input_part_count = 1;  ///< parts in which the input comes
  FrozenJob job;
  std::string consumer;  ///< instance that receives the points; empty: none does

  bool SameAs(const StageTask& other) const {
    return job_uid == other.job_uid && attempt == other.attempt &&
           part.index == other.part.index && part.attempt == other.part.attempt;
  }
  /// Of the same chain: both are wanted, or neither is.
  bool IsOfChain(const StageTask& other) const {
    return job_uid == other.job_uid && attempt == other.attempt;
  }
};

/// What goes to the consumer, in its order, is the cloud or, of a job of marks, these.
struct StageResult {
  PointCloud cloud;
  std::optional<mark::MarkSet> marks;
  StageOutcome outcome;  ///< what goes to the job service; elapsed_s is filled in for it

  std::size_t size() const { return marks ? marks->marks.size() : cloud.size(); }
};

}  // namespace intaglio::host
