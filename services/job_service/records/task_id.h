#pragma once

// What a task is about, and which attempt at it it is.

#include <chrono>
#include <cstdint>
#include <string>

namespace intaglio::job_service {

using Nanoseconds = std::chrono::nanoseconds;

struct TaskId {
  std::string job_uid;
  std::uint32_t attempt = 0;       ///< chain of the job's stages
  std::uint32_t part = 0;          ///< of the discretizing, from 0
  std::uint32_t part_attempt = 0;  ///< in this chain, from 0

  bool operator==(const TaskId&) const = default;
};

}  // namespace intaglio::job_service
