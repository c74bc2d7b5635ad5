#pragma once

// Publishes the TaskStatus of a job that is being made.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/host/stage/kept_tasks.h"

namespace intaglio::cell {

/// TaskStatus of the task in hand, without the fields that TaskPublisher knows by itself.
struct TaskReport {
  std::string job_uid = {};
  std::uint32_t attempt = 0;
  intaglio_TaskState state = intaglio_TASK_ACCEPTED;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  double elapsed_s = 0;
  std::uint64_t estimate_ticks = 0;
  intaglio_ErrorCode error_code = intaglio_ERROR_NONE;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;
  std::string message = {};
  intaglio_PointCounts counts = {};
  std::string alarm = {};
  std::string outcome = {};  ///< serialized StageOutcome
};

class TaskPublisher {
 public:
  TaskPublisher(bus::Bus& bus, const std::string& worker);

  /// At most ten times a second, unless the state or the message changed.
  void Publish(const TaskReport& report, std::chrono::nanoseconds now);

 private:
  std::string worker_;
  bus::Writer<intaglio_TaskStatus> tasks_;
  host::KeptTasks kept_tasks_;
  TaskReport published_;
  std::chrono::nanoseconds next_task_{0};
};

}  // namespace intaglio::cell
