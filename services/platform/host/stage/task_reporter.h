#pragma once

// Publishes the TaskStatus of one worker's tasks.

#include <cstdint>
#include <string>

#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/stage/kept_tasks.h"
#include "services/platform/host/stage/stage_task.h"

namespace intaglio::host {

struct TaskProgress {
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;  ///< 0 while unknown
  double elapsed_s = 0;
  std::uint64_t estimate_ticks = 0;  ///< machining time of the job; 0 while unknown
};

/// Not for use by two threads at once.
class TaskReporter {
 public:
  TaskReporter(bus::Bus& bus, std::string worker, intaglio_Stage stage);

  void Accept(const StageTask& task);
  void Run(const StageTask& task, const TaskProgress& progress);
  void Done(const StageTask& task, const TaskProgress& progress, StageOutcome outcome);
  void Failed(const StageTask& task, const TaskProgress& progress, const Error& error);

 private:
  void Publish(const StageTask& task, intaglio_TaskState state,
               const TaskProgress& progress, const Error& error,
               const std::string& outcome);

  bus::Writer<intaglio_TaskStatus> writer_;
  std::string worker_;
  intaglio_Stage stage_;
  KeptTasks kept_;
};

}  // namespace intaglio::host
