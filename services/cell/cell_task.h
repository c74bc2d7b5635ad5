#pragma once

// The task of a cell: receives EngraveTasks and the permission, has a Maker make the job,
// and publishes its TaskStatus. Written once for every kind of machine.
//
//   none --EngraveTask--> preparing --BeginWork--> made --done--> none
//                             |  ^-- RevokedTask: failed --^
//
// The permission chain is turned also while a job is prepared, and watches the machine
// between jobs: an arm may have been given already, and what is opened then spends it.
//
// Once a turn: Receive, what the maker receives itself, ReceiveTasks, Turn.
// Used from one thread; nothing waits.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "proto/task.pb.h"
#include "services/cell/earlier_work.h"
#include "services/cell/maker.h"
#include "services/cell/permission_intake.h"
#include "services/cell/task_publisher.h"
#include "services/cell/work_clock.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/process/service_host.h"

namespace intaglio::cell {

class CellTask {
 public:
  /// Both outlive this; nothing of `maker` is called before the first turn.
  CellTask(host::ServiceHost& host, const std::string& cell, Maker& maker);

  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(tasks_);
    permission_.AttachTo(loop);
  }

  /// Permission and emergency stops.
  void Receive(std::chrono::nanoseconds now);
  void ReceiveTasks();
  /// Turns the job that is made, or watches the machine.
  void Turn();
  /// The process ends. The job is not over: the next one that is given it takes it up
  /// from the journal.
  void Stop(const std::string& why);

  /// The job was prepared, and its work is about to be made with chain(). `journal`: its
  /// file, for people. `session`: the counters that an earlier process has left.
  void BeginWork(const EarlierWork& earlier, const MachineCounters& session,
                 const std::string& journal);
  void Fail(const Error& error);

  bool has_job() const { return job_.has_value(); }
  const FrozenJob& job() const { return *job_; }
  /// Nothing of it was made yet: it is prepared again with this profile.
  void SetMachine(const MachineSpec& machine) { *job_->mutable_machine() = machine; }
  bool leaves() const { return leaves_; }
  /// A job is there, and its grant holds: submitting alone moves and lights nothing.
  bool has_grant() const;
  PermissionChain& chain() { return chain_; }
  PermissionIntake& permission() { return permission_; }
  const PermissionIntake& permission() const { return permission_; }
  GrantInputs Inputs() const;

 private:
  void Begin(const intaglio_StageTask& task);
  void Revoke(const intaglio_StageTask& task);
  void AlarmRefusal();
  void WatchMachine();
  void TurnWork();
  bool EndWork();
  void PublishWork(bool done);
  void RaiseNoProgress(const std::string& alarm);
  EngraveOutcome Outcome();
  /// Made or missed so far, by any process.
  std::uint64_t DoneCount();
  void End(intaglio_TaskState state, intaglio_ErrorCode code, const std::string& message);
  void Drop();

  host::ServiceHost& host_;
  Maker& maker_;
  bus::Reader<intaglio_StageTask> tasks_;
  PermissionIntake permission_;
  TaskPublisher publisher_;
  PermissionChain chain_;

  std::optional<FrozenJob> job_;
  std::uint32_t attempt_ = 0;
  bool takes_up_ = false;  ///< begun by another process
  bool cancelled_ = false, leaves_ = false, progress_alarmed_ = false;
  std::chrono::nanoseconds now_{0};
  WorkClock clock_;
  std::uint32_t earlier_run_count_ = 0;
  std::string logged_message_, alarmed_refusal_;
};

}  // namespace intaglio::cell
