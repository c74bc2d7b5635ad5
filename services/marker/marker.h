#pragma once

// The service of one cell that marks: receives the marks of the cell's task
// (services/cell/cell_task.h), has them made, and publishes the interlocks. Everything
// that decides about a mark is in marking.h. It has the role of the synchronizer: the
// cell's process that makes the job.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/cell/cell_task.h"
#include "services/cell/maker.h"
#include "services/cell/manual/manual_desk.h"
#include "services/cell/manual/teacher.h"
#include "services/marker/begun_zero.h"
#include "services/marker/marking.h"
#include "services/marker/marking_preparation.h"
#include "services/platform/host/peers/machine_reporter.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/flow.h"
#include "services/platform/host/threads/computation.h"

namespace intaglio::marker {

class Marker final : private cell::Maker {
 public:
  /// `machine`: the profile of this cell, and the file `profile` that it was read from;
  /// no value of the machine is taken from a task.
  Marker(host::ServiceHost& host, const MachineSpec& machine, const std::string& profile,
         std::unique_ptr<drivers::MarkDriver> driver);
  ~Marker() override;

  /// One turn of the loop; never blocks.
  void Turn(std::chrono::nanoseconds now);
  /// No more marks. Turn until stopped(). The job is not over: the next marker that is
  /// given it takes it up from the journal.
  void Stop() { task_.Stop("the marker was stopped"); }
  bool stopped() const { return !marking_; }
  /// Another host has the controller: Turn does nothing more.
  bool taken_over() const { return driver_->state().taken_over; }
  /// The controller answers: from now on openings of key and door are counted.
  bool watches() const { return line_up(); }
  /// No job is here, and nothing moves by hand.
  bool rests() const { return !task_.has_job() && !(desk_ && desk_->moves()); }

  int line_fd() const { return driver_->fd(); }
  int journal_fd() const { return journal_ ? journal_->event_fd() : -1; }
  template <typename Loop>
  void AttachTo(Loop& loop) {
    task_.AttachTo(loop);
    loop.Attach(intake_.reader());
    if (!desk_) return;
    loop.Attach(desk_->commands());
    loop.Attach(desk_->interlocks());
  }

 private:
  using Preparation = host::Computation<PreparedMarking>;

  cell::WorkStates* work() override { return marking_.get(); }
  bool line_up() const override { return driver_->state().link_up; }
  std::string Refusal() const override { return driver_->state().refusal; }
  std::string WhyNoArmCounts() const override {
    const std::string& why = marker::WhyNoArmCounts(driver_->state());
    return why.empty() ? zero_.refusal() : why;
  }
  cell::ChainLinks Links(const cell::GrantInputs& inputs) const override {
    return LinksOf(driver_->state(), inputs);
  }
  Status Begin(FrozenJob& job, const intaglio_StageTask& task) override;
  void TurnWork(const cell::GrantInputs& inputs) override;
  void Drop() override;

  void ReceiveMarks();
  void Prepare(std::optional<mark::MarkSet> marks);
  void AcceptPrepared();
  void CheckZero();
  void TurnByHand();
  void PublishInterlock();

  MachineSpec machine_;
  std::string cell_;
  std::unique_ptr<drivers::MarkDriver> driver_;
  host::MarkIntake intake_;
  bus::Writer<intaglio_Interlock> interlocks_;
  host::MachineReporter reporter_;
  std::unique_ptr<cell::Teacher> teacher_;
  std::optional<cell::ManualDesk> desk_;  ///< of a controller that a person can move

  BegunZero zero_;
  std::unique_ptr<Preparation> preparation_;
  std::vector<std::unique_ptr<Preparation>> abandoned_;
  std::shared_ptr<cell::JournalWriter> journal_;
  std::unique_ptr<Marking> marking_;
  cell::CellTask task_;

  std::chrono::nanoseconds now_{0}, next_interlock_{0};
  std::chrono::nanoseconds state_at_{0};  // when the controller's newest status came
  std::uint64_t stop_revision_ = 0;
  std::uint32_t published_interlocks_ = ~0u;
  std::uint64_t state_number_ = 0;
};

}  // namespace intaglio::marker
