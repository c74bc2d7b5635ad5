#pragma once

// ServiceHealth and TaskStatus of the workers, as far as they count: written by the
// process that they name, with the identity of the service that they name, a cell's about
// engraving and a stage worker's about the rest
// (services/platform/host/peers/identity_role.h).
//
// Each identity has readers of its own: what another one writes about the same instance
// or task neither takes the place of a sample here nor ends an instance. Within an
// identity every sample is kept until it is taken. Used from one thread.

#include <chrono>
#include <functional>
#include <map>
#include <string>

#include "services/platform/bus/bus.h"
#include "services/platform/host/peers/process_instances.h"

namespace intaglio::job_service {

class WorkerReports {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  using TaskSink = std::function<void(const intaglio_TaskStatus&)>;
  /// `alive`: false when the process is gone; then only its instance is valid.
  using HealthSink = std::function<void(const intaglio_ServiceHealth&, bool alive)>;

  /// Reads those of the stage workers.
  explicit WorkerReports(bus::Bus& bus);

  /// Reads those of this cell, too; retained samples come at once.
  void OpenCell(const std::string& cell);
  void TakeTasks(const TaskSink& sink, Nanoseconds now);
  void TakeHealth(const HealthSink& sink, Nanoseconds now);

  /// Attaches the readers of stage workers alone: cells are added while the loop runs.
  template <typename Loop>
  void AttachTo(Loop& loop) {
    for (auto& [partition, readers] : readers_) {
      loop.Attach(readers.tasks);
      loop.Attach(readers.health);
    }
  }

 private:
  struct Readers {
    bus::Reader<intaglio_TaskStatus> tasks;
    bus::Reader<intaglio_ServiceHealth> health;
  };
  void Open(const std::string& role);
  /// In the log, once a minute at most.
  void Refuse(const char* topic, std::string_view named, const bus::SampleOrigin& origin,
              Nanoseconds now);

  bus::Bus& bus_;
  std::map<std::string, Readers> readers_;  // by partition
  host::ProcessInstances instances_;
  Nanoseconds next_warning_{0};
};

}  // namespace intaglio::job_service
