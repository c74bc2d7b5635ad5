#pragma once

// A JobQueue with one job or more on cell "c", everybody else played by the test, a clock
// of its own, and what it decides as text.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/job_service/queue/job_queue.h"

namespace intaglio::job_service {

using namespace std::chrono_literals;

class RecordingActions : public JobActions {
 public:
  void Changed(const JobRecord& job) override { kept[job.uid] = job; }
  void Progressed(const JobRecord& job) override { ++progress[job.uid]; }
  void Give(const TaskOrder& order, const JobRecord& job) override {
    // What follows from a change comes after it was kept.
    if (!order.revoked) {
      EXPECT_EQ(kept.at(job.uid).attempt, order.task.attempt);
    }
    const bool part = order.stage == intaglio_STAGE_DISCRETIZE && job.parts.size() > 1;
    const TaskId& task = order.task;
    orders.push_back(fmt::format(
        "{}{} {} {}{}{}{}",
        order.revoked   ? "revoke "
        : order.take_up ? "take up "
                        : "",
        order.worker, task.job_uid, task.attempt,
        part ? fmt::format(" {}.{}/{}", task.part, task.part_attempt, job.parts.size())
             : "",
        order.consumer.empty() ? "" : " > ", order.consumer));
  }
  void StopFeed(const std::string& uid) override { orders.push_back("stop " + uid); }
  void Forgotten(const JobRecord& job) override { forgotten.push_back(job.uid); }
  void WorkerForgotten(const std::string& name) override { forgotten.push_back(name); }
  void PieceChanged(const PieceRecord& piece) override { pieces[piece.cell] = piece; }
  void BlockLoaded(const LoadedBlock& block) override { blocks.push_back(block); }
  void LeftOutChanged(const LeftOut& worker) override {
    std::erase_if(left_out,
                  [&](const LeftOut& other) { return other.worker == worker.worker; });
    if (!worker.why.empty()) left_out.push_back(worker);
    if (!worker.admitted_by.empty()) admitted_by = worker.admitted_by;
  }
  std::vector<std::string> Orders() { return std::exchange(orders, {}); }

  std::map<std::string, JobRecord> kept;
  std::map<std::string, int> progress;
  std::map<std::string, PieceRecord> pieces;  // by cell
  std::vector<LoadedBlock> blocks;
  std::vector<LeftOut> left_out;  // as it is kept
  std::string admitted_by;        // the last one
  std::vector<std::string> orders;
  std::vector<std::string> forgotten;
};

/// Why a task failed, or is paused.
struct Cause {
  Cause() = default;
  Cause(intaglio_ErrorCode code) : error(code) {}
  Cause(intaglio_PauseReason reason) : pause(reason) {}
  intaglio_ErrorCode error = intaglio_ERROR_NONE;
  intaglio_PauseReason pause = intaglio_PAUSE_NONE;
};

class JobQueueTest : public testing::Test {
 protected:
  void Ready(const std::string& instance, intaglio_ServiceRole role,
             intaglio_HealthState state = intaglio_HEALTH_READY) {
    queue_.Receive(WorkerView{instance, role, state,
                              role == intaglio_ROLE_SYNCHRONIZER ? "c" : "", ""},
                   now_);
  }
  void ReadyAll() {
    Ready("d", intaglio_ROLE_DISCRETIZER);
    Ready("s", intaglio_ROLE_SORTER);
    Ready("y", intaglio_ROLE_SYNCHRONIZER);
  }
  void Add(std::uint32_t number, const std::string& cell = "c", std::int32_t priority = 0,
           const std::string& makes = "points") {
    JobRecord job;
    job.number = number;
    job.uid = fmt::format("j{}", number);
    job.epoch = kEpoch;
    job.cell = cell;
    job.priority = priority;
    job.makes = makes;
    queue_.Add(job);
    queue_.Turn(now_);
  }
  void Task(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done = 0,
            std::uint64_t total = 0, Cause cause = {}, const std::string& text = "") {
    const bool in_parts = stage == intaglio_STAGE_DISCRETIZE;
    TaskView task;
    task.task = job().TaskOf(stage);
    task.stage = stage;
    task.worker = in_parts ? job().parts.at(0).worker : job().stage(stage).worker;
    task.state = state;
    task.done_count = done;
    task.total_count = total;
    task.error_code = cause.error;
    task.pause_reason = cause.pause;
    task.message = text;
    task.estimate_ticks = stage == intaglio_STAGE_ENGRAVE ? 77 : 0;
    queue_.Receive(task, now_);
    queue_.Turn(now_);
  }
  /// A report about a part from the worker that has it.
  TaskView PartReport(std::uint32_t part, intaglio_TaskState state,
                      std::uint64_t done = 100, std::uint64_t total = 100) {
    TaskView task;
    task.task = job().TaskOf(intaglio_STAGE_DISCRETIZE, part);
    task.worker = job().parts.at(part).worker;
    task.state = state;
    task.done_count = done;
    task.total_count = total;
    return task;
  }
  void Report(const TaskView& report) {
    queue_.Receive(report, now_);
    queue_.Turn(now_);
  }
  void Done(std::uint32_t part) { Report(PartReport(part, intaglio_TASK_DONE)); }
  /// Each part is done by the worker that has it; parts without a worker are left.
  void DiscretizeAll() {
    for (std::uint32_t part = 0; part < job().parts.size(); ++part) {
      if (!job().parts[part].worker.empty() && !job().parts[part].done) Done(part);
    }
  }
  static TaskView SortStatus(std::uint32_t attempt, intaglio_TaskState state) {
    TaskView task;
    task.task = {"j1", attempt, 0, 0};
    task.stage = intaglio_STAGE_SORT;
    task.worker = "s";
    task.state = state;
    return task;
  }
  /// The order of a client that has seen the newest status of the job.
  CommandView Order(intaglio_JobCommandKind kind, const std::string& uid = "j1") {
    CommandView command;
    command.basis = intaglio_ARM_BY_PERSON;
    command.sender = "ann@shop-1";
    command.number = ++command_;
    command.job_uid = uid;
    command.epoch = kEpoch;
    command.kind = kind;
    command.operator_name = "ann@shop";
    const JobRecord* job = queue_.Find(uid);
    command.disarm_count = job == nullptr ? 0 : job->arm.disarm_count();
    return command;
  }
  CommandAnswer Send(const CommandView& command) {
    CommandAnswer answer = queue_.Receive(command, now_);
    queue_.Turn(now_);
    return answer;
  }
  bool Command(intaglio_JobCommandKind kind) { return Send(Order(kind)).taken(); }
  /// A resume that asks to fire uncertain points.
  CommandAnswer ResumeFiringUncertain() {
    CommandView command = Order(intaglio_COMMAND_RESUME);
    command.fire_uncertain = true;
    return Send(command);
  }
  void Lose(const std::string& instance) {
    queue_.WorkerLost(instance, now_);
    queue_.Turn(now_);
  }
  // Up to where the whole path is in the synchronizer.
  void LoadPath() {
    DiscretizeAll();
    Task(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100, 100);
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits for the arm");
  }
  void Engrave(std::uint64_t done = 10) {
    ASSERT_TRUE(Command(intaglio_COMMAND_ARM));
    now_ += 1s;
    ASSERT_TRUE(Granted());
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, done, 100);
    ASSERT_EQ(job().state, intaglio_JOB_ENGRAVING);
  }
  bool Granted() {
    for (const PermissionView& permission : queue_.Permissions(now_)) {
      EXPECT_EQ(permission.epoch, kEpoch);
      if (permission.granted) return true;
    }
    return false;
  }
  const JobRecord& job() { return *queue_.Find("j1"); }

  static constexpr std::uint64_t kEpoch = 0xabc;
  Nanoseconds now_{100s};
  std::uint64_t command_ = 0;
  RecordingActions actions_;
  JobQueue queue_{actions_};
};

}  // namespace intaglio::job_service
