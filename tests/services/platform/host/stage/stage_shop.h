#pragma once

// Plays everybody but the one worker that is tested, which runs as a process of its own:
// the job service that gives the tasks, the producer of the worker's input, and the
// consumer of its output.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/task.pb.h"
#include "services/platform/bus/flow.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/task_part.h"
#include "tests/services/platform/bus/child_program.h"

namespace intaglio::test {

/// TaskStatus, copied.
struct TaskReport {
  std::string job_uid;
  std::uint32_t attempt = 0;
  host::TaskPart part;
  intaglio_TaskState state = intaglio_TASK_ACCEPTED;
  std::uint64_t done_count = 0, total_count = 0;
  intaglio_ErrorCode error_code = intaglio_ERROR_NONE;
  std::string message;
  StageOutcome outcome;
  std::uint64_t estimate_ticks = 0;
};

class StageShop {
 public:
  StageShop(const std::string& program, intaglio_Stage stage,
            const bus::Topic<intaglio_StageTask>& tasks);

  /// Until the worker's health is as asked for.
  bool AwaitHealth(intaglio_HealthState state);
  /// Until the worker's health is gone from the bus.
  bool AwaitGone();
  void Give(const FrozenJob& job, std::uint32_t attempt, const std::string& consumer,
            host::TaskPart part = {}, std::uint32_t input_part_count = 1);
  void GiveBytes(const std::string& job_uid, std::uint32_t attempt,
                 const std::string& frozen_job);
  void Revoke(const std::string& job_uid, std::uint32_t attempt,
              host::TaskPart part = {});
  /// The worker's newest report of this part, if there is one; does not wait.
  std::optional<TaskReport> Find(const std::string& job_uid, host::TaskPart part,
                                 intaglio_TaskState state);
  /// The newest report of this job; waits until `enough` accepts it.
  std::optional<TaskReport> AwaitReport(
      const std::string& job_uid, const std::function<bool(const TaskReport&)>& enough);
  /// The report with which the attempt ended.
  std::optional<TaskReport> AwaitEnd(const std::string& job_uid, std::uint32_t attempt,
                                     host::TaskPart part = {});
  /// The job service is gone, as far as the worker can see.
  void CloseTasks() { task_writer_.reset(); }

  bus::Bus& bus() { return bus_; }
  ChildProgram& worker() { return worker_; }
  const std::string& instance() const { return instance_; }

 private:
  void Poll();
  void Write(intaglio_StageTask task);

  bus::Bus bus_;
  intaglio_Stage stage_;
  std::unique_ptr<bus::Writer<intaglio_StageTask>> task_writer_;
  bus::Reader<intaglio_ServiceHealth> health_reader_;
  bus::Reader<intaglio_TaskStatus> status_reader_;
  ChildProgram worker_;
  std::string instance_;
  std::optional<intaglio_HealthState> health_;
  std::vector<TaskReport> reports_;
};

/// A frozen job with every default filled in, for the profile deploy/machines/els-03.
/// The beam's cone has the tangent 0.1.
FrozenJob FrozenJobOf(const std::string& job_uid, JobSpec spec);
/// A job for this machine's synchronizer, which refuses another profile, other optical
/// values than those of its lens and laser, and points outside the block.
FrozenJob CellJobOf(const std::string& job_uid, const MachineSpec& machine,
                    const Vec3& block_mm);

/// Feeds model files as chunks of 1000 bytes, under credit. False: the worker does not
/// want them all.
bool FeedModels(bus::Bus& bus, const std::string& job_uid, std::uint32_t attempt,
                const std::vector<std::string>& files, host::TaskPart part = {});

}  // namespace intaglio::test
