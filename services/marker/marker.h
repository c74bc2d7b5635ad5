#pragma once

// The service of one cell that marks: takes an EngraveTask and its marks, and has them
// made; publishes the task and the interlocks. Everything that decides about a mark is in
// marking.h. It has the role of the synchronizer: the cell's process that makes the job.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/cell/manual/manual_desk.h"
#include "services/cell/permission_intake.h"
#include "services/cell/task_publisher.h"
#include "services/marker/hand_teacher.h"
#include "services/marker/marking.h"
#include "services/marker/marking_preparation.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/flow.h"
#include "services/platform/host/threads/computation.h"

namespace intaglio::marker {

class Marker {
 public:
  /// `machine`: the profile of this cell; no value of the machine is taken from a task.
  Marker(host::ServiceHost& host, const MachineSpec& machine,
         std::unique_ptr<drivers::MarkDriver> driver);
  ~Marker();

  /// One turn of the loop; never blocks.
  void Turn(std::chrono::nanoseconds now);
  /// No more marks. Turn until stopped(). The job is not over: the next marker that is
  /// given it takes it up from the journal.
  void Stop();
  bool stopped() const { return !marking_; }
  /// Another host has the controller: Turn does nothing more.
  bool taken_over() const { return driver_->state().taken_over; }
  /// The controller answers: from now on openings of key and door are counted.
  bool watches() const { return driver_->state().link_up; }

  int line_fd() const { return driver_->fd(); }
  int journal_fd() const { return journal_ ? journal_->event_fd() : -1; }
  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(tasks_);
    permission_.AttachTo(loop);
    loop.Attach(intake_.reader());
    if (!desk_) return;
    loop.Attach(desk_->commands());
    loop.Attach(desk_->interlocks());
  }

 private:
  using Preparation = host::Computation<PreparedMarking>;

  void TakeTasks();
  void Begin(const intaglio_StageTask& task);
  void TakeMarks();
  void Prepare(std::optional<mark::MarkSet> marks);
  void TakePrepared();
  void WatchMachine();
  void TurnByHand();
  void TurnMarking();
  void AlarmRefusal();
  void PublishInterlock();
  void FailTask(const Error& error);
  void EndTask(intaglio_TaskState state, intaglio_ErrorCode code,
               const std::string& message);
  void DropTask();
  cell::GrantInputs Inputs() const;
  EngraveOutcome Outcome() const;

  host::ServiceHost& host_;
  MachineSpec machine_;
  std::string cell_;
  std::unique_ptr<drivers::MarkDriver> driver_;
  bus::Reader<intaglio_StageTask> tasks_;
  cell::PermissionIntake permission_;
  host::MarkIntake intake_;
  cell::TaskPublisher task_publisher_;
  bus::Writer<intaglio_Interlock> interlocks_;
  cell::PermissionChain chain_;
  HandTeacher teacher_;
  std::optional<cell::ManualDesk> desk_;  ///< of a controller that a person can move

  std::optional<FrozenJob> job_;
  std::uint32_t attempt_ = 0;
  bool takes_up_ = false;  // begun by another process
  bool cancelled_ = false, leaves_ = false, stall_alarmed_ = false;
  std::unique_ptr<Preparation> preparation_;
  std::vector<std::unique_ptr<Preparation>> abandoned_;
  std::shared_ptr<cell::JournalWriter> journal_;
  std::unique_ptr<Marking> marking_;

  std::chrono::nanoseconds now_{0}, turned_at_{0}, next_interlock_{0};
  std::chrono::nanoseconds worked_{0};  // without what it waited for
  std::uint64_t stop_revision_ = 0;
  std::uint32_t published_interlocks_ = ~0u;
  std::string logged_message_, alarmed_refusal_;
};

}  // namespace intaglio::marker
