#pragma once

// A JobQueue with discretizers that do what they are given, right, wrong or slowly, and a
// sorter and a synchronizer that have the path as soon as all parts are done.

#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {

class GivenOrders : public RecordingActions {
 public:
  void Give(const TaskOrder& order, const JobRecord& job) override {
    RecordingActions::Give(order, job);
    if (order.stage != intaglio_STAGE_DISCRETIZE) return;
    if (order.revoked) {
      given[order.worker].clear();
      return;
    }
    given[order.worker].push_back(order);
    if (!host::IsComparison(order.task.part_attempt)) return;
    EXPECT_EQ(order.consumer, "") << "its points would reach the sorter";
    EXPECT_NE(order.worker, job.comparison->made.front().worker);
    comparisons.push_back(order);
  }
  std::map<std::string, std::deque<TaskOrder>> given;  // by worker
  std::vector<TaskOrder> comparisons;
};

class DiscretizerShop : public testing::Test {
 protected:
  void Ready(const std::string& name, intaglio_ServiceRole role) {
    queue_.Receive(WorkerView{name, role, intaglio_HEALTH_READY,
                              role == intaglio_ROLE_SYNCHRONIZER ? "c" : "", ""},
                   now_);
  }
  void Start(const std::string& name) {
    discretizers_.insert(name);
    Ready(name, intaglio_ROLE_DISCRETIZER);
    queue_.Turn(now_);
  }
  void Kill(const std::string& name) {
    discretizers_.erase(name);
    actions_.given.erase(name);
    queue_.WorkerLost(name, now_);
    queue_.Turn(now_);
  }
  void ReadyAll() {
    Ready("s", intaglio_ROLE_SORTER);
    Ready("y", intaglio_ROLE_SYNCHRONIZER);
    for (const std::string& name : discretizers_)
      if (actions_.given[name].empty()) Ready(name, intaglio_ROLE_DISCRETIZER);
  }
  /// Another job, of which some parts are given.
  const JobRecord& Begin() {
    JobRecord job;
    job.number = ++number_;
    job.uid = fmt::format("j{}", number_);
    job.epoch = 1;
    job.cell = "c";
    now_ += 3s;
    ReadyAll();
    queue_.Add(job);
    queue_.Turn(now_);
    return *queue_.Find(job.uid);
  }
  const JobRecord& job() { return *queue_.Find(fmt::format("j{}", number_)); }

  TaskView ReportOf(const TaskOrder& order, intaglio_TaskState state) {
    TaskView report;
    report.task = order.task;
    report.stage = order.stage;
    report.worker = order.worker;
    report.state = state;
    report.done_count = report.total_count = 100;
    report.elapsed_s = seconds_.contains(order.worker) ? seconds_[order.worker] : 1;
    report.checksum = wrong_.contains(order.worker)
                          ? "of " + order.worker
                          : fmt::format("part {}", order.task.part);
    return report;
  }
  void Report(const TaskView& report) {
    queue_.Receive(report, now_);
    queue_.Turn(now_);
  }
  /// The oldest task of this one; false: it has none.
  bool WorkOnce(const std::string& name) {
    auto& tasks = actions_.given[name];
    if (tasks.empty()) return false;
    const TaskOrder order = tasks.front();
    Report(ReportOf(order, intaglio_TASK_ACCEPTED));
    if (tasks.empty()) return true;  // revoked meanwhile
    tasks.pop_front();
    Report(ReportOf(order, intaglio_TASK_DONE));
    if (tasks.empty()) {
      Ready(name, intaglio_ROLE_DISCRETIZER);
      queue_.Turn(now_);
    }
    return true;
  }
  /// In turns, until nobody has a task or `until` holds.
  void Work(const std::function<bool()>& until = [] { return false; }) {
    for (bool any = true; any && !until();) {
      any = false;
      const auto names = discretizers_;
      for (const std::string& name : names) {
        if (!until()) any = WorkOnce(name) || any;
      }
    }
  }
  TaskView CellReport(intaglio_Stage stage, intaglio_TaskState state,
                      std::uint64_t done = 0) {
    TaskView report;
    report.task = job().TaskOf(stage);
    report.stage = stage;
    report.worker = job().stage(stage).worker;
    report.state = state;
    report.done_count = done;
    report.total_count = 100;
    return report;
  }
  void LoadPath() {
    Report(CellReport(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100));
    Report(CellReport(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING));
  }
  CommandAnswer Send(intaglio_JobCommandKind kind) {
    CommandView command;
    command.basis = intaglio_ARM_BY_PERSON;
    command.sender = "ann";
    command.number = ++command_;
    command.job_uid = job().uid;
    command.epoch = 1;
    command.kind = kind;
    command.operator_name = "ann";
    command.disarm_count = job().arm.disarm_count();
    const CommandAnswer answer = queue_.Receive(command, now_);
    queue_.Turn(now_);
    return answer;
  }
  bool Granted() {
    now_ += 1s;
    for (const PermissionView& permission : queue_.Permissions(now_))
      if (permission.granted) return true;
    return false;
  }
  /// Everybody has dropped what was revoked.
  void Rest() {
    now_ += 3s;
    ReadyAll();
    queue_.Turn(now_);
  }
  /// The job ends, and its machine is free.
  void End() {
    Send(intaglio_COMMAND_CANCEL);
    actions_.given.clear();
    Rest();
  }
  /// Whole jobs, up to where the next part that is done is compared.
  void WorkUpToAComparison() {
    for (std::uint32_t done = 0;;) {
      Begin();
      const auto is_due = [&] {
        std::uint32_t here = 0;
        for (const PartRecord& part : job().parts) here += part.done ? 1 : 0;
        return done + here + 1 >= kCompareEvery;
      };
      Work(is_due);
      if (is_due()) return;
      done += static_cast<std::uint32_t>(job().parts.size());
      End();
    }
  }
  void WorkUntilCompared() {
    WorkUpToAComparison();
    Work([this] { return job().comparison && job().comparison->at_work(); });
    ASSERT_TRUE(job().comparison);
  }

  Nanoseconds now_{100s};
  GivenOrders actions_;
  JobQueue queue_{actions_};
  std::set<std::string> discretizers_, wrong_;
  std::map<std::string, double> seconds_;  ///< for a part; else 1
  std::uint32_t number_ = 0;
  std::uint64_t command_ = 0;
};

}  // namespace intaglio::job_service
