#pragma once

// The service of one cell that makes points: receives the path of the cell's task
// (services/cell/cell_task.h), has it made, and publishes pulses, lamp and interlocks.
// Everything that decides about a pulse is in engraving.h.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/cell/cell_task.h"
#include "services/cell/maker.h"
#include "services/job/machine/mounted_parts.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/flow.h"
#include "services/synchronizer/cell_drive.h"
#include "services/synchronizer/engraving.h"
#include "services/synchronizer/job_planner.h"
#include "services/synchronizer/lamp_hold.h"
#include "services/synchronizer/laser_stop.h"
#include "services/synchronizer/light_by_hand.h"
#include "services/synchronizer/motion_intake.h"
#include "services/synchronizer/outputs.h"
#include "services/synchronizer/publisher.h"

namespace intaglio::synchronizer {

class Synchronizer final : private Maker {
 public:
  /// `machine`: the profile of this cell, read from `machine_file`; no value of the
  /// machine is taken from a task. `mounted`: as far as it is known. `laser`: not null.
  Synchronizer(host::ServiceHost& host, const MachineSpec& machine,
               std::string machine_file, const MountedParts& mounted,
               std::unique_ptr<drivers::LaserController> laser);
  ~Synchronizer() override;

  /// One turn of the loop; never blocks.
  void Turn(std::chrono::nanoseconds now);
  /// No more pulses: disarms, closes the shutters. Turn until stopped(). The job is not
  /// over: the next synchronizer that is given it takes it up from the journal.
  void Stop();
  bool stopped() const {
    return !engraving_ && !(lamp_hold_.holds() && laser_.up()) && !outputs_.any_on();
  }
  /// Another synchronizer has the laser: Turn does nothing more.
  bool taken_over() const { return laser_.taken_over(); }

  /// The laser controller answers: from now on openings of key and door are counted.
  bool watches() const { return line_up(); }
  /// No job is here, and nothing is lit by hand.
  bool rests() const { return !task_.has_job() && !light_.holds(); }

  int line_fd() const { return laser_.fd(); }
  int journal_fd() const { return journal_ ? journal_->event_fd() : -1; }
  template <typename Loop>
  void AttachTo(Loop& loop) {
    task_.AttachTo(loop);
    motion_.AttachTo(loop);
    loop.Attach(by_hand_);
    loop.Attach(intake_.reader());
    loop.Attach(credit_.reader());
  }

 private:
  WorkStates* work() override { return engraving_.get(); }
  bool line_up() const override { return laser_.up(); }
  std::string Refusal() const override { return laser_.refusal(); }
  std::string WhyNoArmCounts() const override;
  ChainLinks Links(const GrantInputs& inputs) const override;
  Status Begin(FrozenJob& job, const intaglio_StageTask& task) override;
  void TurnWork(const GrantInputs& inputs) override;
  std::string PendingAtEnd() const override;
  void NoteDone() override;
  std::uint64_t estimate_ticks() const override { return plan_.ticks; }
  void AddTo(EngraveOutcome& outcome) const override;
  void Drop() override;
  void NoteEnd(const std::string& job_uid, bool done) override;

  /// Nothing is armed or settled, and nothing is lit by hand.
  bool IsIdle() const;
  Status ReadTaught();
  void ReceivePath();
  /// `path`: none when it is in the job's folder already.
  void Prepare(std::optional<PointCloud> path);
  void AcceptPrepared();
  void StartEngraving(PreparedJob prepared);
  void AcceptPlan();
  void TurnDrive();
  void Approach();
  void DriveTo(const char* name, const Vector3& axes, const std::string& job_uid);
  bool BlockIsAway() const;
  void EndApproach();
  void BringBlock();
  void EndBlockDrive();
  void FailBlock(const std::string& why);
  void CheckZeros();
  void PrepareAnew();
  void TurnLight();
  void TurnOutputs();

  host::ServiceHost& host_;
  MachineSpec machine_;
  std::string machine_file_;
  MountedParts mounted_;
  std::string cell_;
  MotionIntake motion_;
  bus::Reader<intaglio_ManualState> by_hand_;
  bus::CreditBook credit_;
  bus::Writer<intaglio_MotionSegmentBatch> segments_;
  host::PathIntake intake_;
  JobPlanner planner_;
  Publisher publisher_;
  std::unique_ptr<drivers::LaserController> laser_driver_;
  drivers::LaserController& laser_;
  LightByHand light_;
  LampHold lamp_hold_;
  LaserStop laser_stop_;
  Outputs outputs_;
  MotionFeed feed_;
  CellDrive drive_;
  std::unique_ptr<JournalWriter> journal_;
  std::unique_ptr<Engraving> engraving_;
  CellTask task_;

  PlanSummary plan_;  ///< The whole job's, without pauses; empty until it is computed.
  bool planned_ = false;  ///< The computation of plan_ has ended.
  /// kDue: the job begins with a drive, or at least where another one ended, as soon as
  /// it has a grant. kDrives: to the taught position, kBlock: then the block to its
  /// place.
  enum class ApproachState : std::uint8_t { kNone, kDue, kDrives, kBlock, kOver };
  ApproachState approach_ = ApproachState::kNone;
  Grant block_driven_by_;  ///< the grant by which the block was driven last
  std::chrono::nanoseconds block_driven_at_{0};  ///< when that ended
  std::string block_failure_;                    ///< see EngravingInputs
  Grant zeros_checked_;       ///< the newest grant whose zeros were compared
  std::string zero_refusal_;  ///< why they refuse it; empty: they do not
  std::chrono::nanoseconds now_{0};
};

}  // namespace intaglio::synchronizer
