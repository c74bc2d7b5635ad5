#pragma once

// TaskStatus of one worker: changes at once, progress at most ten times a second.

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/bus/bus.h"
#include "services/host/task_part.h"

namespace intaglio::host {

struct TaskProgress {
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;  ///< 0 while unknown
  double elapsed_s = 0;
};

/// Not for use by two threads at once.
class TaskReporter {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  TaskReporter(bus::Bus& bus, std::string worker, intaglio_Stage stage);

  void Accept(const std::string& job_uid, std::uint32_t attempt, TaskPart part,
              TimePoint now);
  void Run(const TaskProgress& progress, TimePoint now);
  void Done(const TaskProgress& progress, StageOutcome outcome);
  void Failed(const TaskProgress& progress, const Error& error);

 private:
  void Publish(intaglio_TaskState state, const TaskProgress& progress, const Error& error,
               const std::string& outcome);
  void Remember();

  bus::Writer<intaglio_TaskStatus> writer_;
  std::string worker_;
  intaglio_Stage stage_;
  std::string job_uid_;
  std::uint32_t attempt_ = 0;
  TaskPart part_;
  TimePoint next_{};
  // Jobs and parts whose status is kept for late joiners.
  std::deque<std::pair<std::string, std::uint32_t>> told_;
};

}  // namespace intaglio::host
