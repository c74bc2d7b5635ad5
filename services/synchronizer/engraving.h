#pragma once

// Makes the points of one job: a state machine over the parts that do the work.
//
//               laser up, lamp warm,        chain whole,
//               stage state known           points open
//   kPreparing ----------------------> kWaiting --------> kRunning
//       ^                               |  ^  ^              |  |
//       |  lamp or laser line lost      |  |  | all made,    |  |
//       +-------------------------------+  |  | at rest      |  |  a link lost, a point
//                                       |  |  +--------------+  |  passed by
//        nothing is left                |  |                    v
//   kDone <-----------------------------+  +-------------- kHalting <-- taken up
//     ^                  all armed settled, at rest             |
//     +------ stopped: settled, or the line stays down ----------+
//
// | phase      | part that works                                                     |
// |------------|---------------------------------------------------------------------|
// | kPreparing | MachinePreparation: lamp, safe state                                |
// | kWaiting   | Consent: uncertain points; Shutters: closed                         |
// | kRunning   | EngravingRun: one pass over the open points, from rest to rest;     |
// |            | TickWindows arms its ticks; Shutters: those of its channels open    |
// | kHalting   | Settling: disarm, brake, and a result for every armed point         |
//
// kHalting is not left before the controller has reported that nothing is armed, and its
// counter was checked if the line was lost. A job that an earlier life left begins there.
// A permission that is late, not withdrawn, lets a machine whose time is simulated wait:
// nothing more is armed, so its time stops behind what is, and the run goes on with the
// same ticks when it comes. Any other machine halts.
//
// After a fault (anything but a withdrawn permission) only a new grant counts: nothing
// restarts by itself (permission_chain.h). The same holds, if the job asks for it, when
// uncertain points are left (it is not known whether they were fired), even if nothing
// else is left.
//
// Where a stage carries the block, it is driven to the job's place before the first run,
// and again where the controller reports it elsewhere, each time by a grant
// (Synchronizer). A drive that does not bring it there is a fault.
//
// No pulse without: an intent on disk, the motion for its tick in the controller, and
// the whole permission chain at the moment of arming. Used from one thread; no waits.

#include <cstdint>
#include <string>

#include "services/cell/journal_writer.h"
#include "services/cell/permission_chain.h"
#include "services/cell/work_states.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/engraving/consent.h"
#include "services/synchronizer/engraving/engraving_inputs.h"
#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/engraving/engraving_run.h"
#include "services/synchronizer/engraving/halt_reason.h"
#include "services/synchronizer/engraving/machine_preparation.h"
#include "services/synchronizer/engraving/motion_feed.h"
#include "services/synchronizer/engraving/progress_watch.h"
#include "services/synchronizer/engraving/settling.h"
#include "services/synchronizer/engraving/shutters.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/pulse_record.h"
#include "services/synchronizer/pulses/pulse_schedule.h"
#include "services/synchronizer/pulses/tick_horizon.h"
#include "services/synchronizer/pulses/tick_windows.h"

namespace intaglio::synchronizer {

class Engraving final : public WorkStates {
 public:
  enum class Phase { kPreparing, kWaiting, kRunning, kHalting, kDone };

  /// All outlive this. `chain` has begun the job, and is turned by this from now on.
  Engraving(EngravingJob job, drivers::LaserController& laser, MotionFeed& feed,
            JournalWriter& journal, PermissionChain& chain,
            PulseSchedule::ResultSink results);

  void Turn(const EngravingInputs& inputs);
  /// The controller's report, as drivers::LaserController::Poll hands it over.
  void Receive(const link::PulseReport& report) { ticks_.Receive(report); }
  void Receive(const link::PastReport& report) {
    if (phase_ == Phase::kHalting) settling_.Receive(report);
  }

  /// The tick of each point in an undisturbed pass, once it is known.
  void SetPlan(std::vector<std::uint32_t> point_ticks) {
    progress_.SetPlan(std::move(point_ticks));
  }

  Phase phase() const { return phase_; }
  Activity activity() const override;
  const PointLedger& ledger() const override { return record_.ledger(); }
  bool waits() const override {
    const bool begun = started() || faulted() || (granted_ && !job_.block_misfit.empty());
    return begun && phase_ != Phase::kRunning && !starts_again_ && !message_.empty();
  }
  std::uint32_t run_count() const override { return run_.count(); }
  /// A grant has switched the lamp on, or has found it on.
  bool has_lamp() const { return preparation_.has_lamp(); }
  const FiredTicks& fired_ticks() const { return record_.fired_ticks(); }
  /// Speed overrides that motion was planned with, and how often they changed.
  std::uint32_t min_speed_percent() const { return run_.min_speed_percent(); }
  std::uint32_t max_speed_percent() const { return run_.max_speed_percent(); }
  std::uint32_t speed_changes() const { return run_.speed_changes(); }
  std::uint64_t settled_by_memory_count() const override {
    return settling_.settled_by_memory_count();
  }

 private:
  void Note(const PulseResult& result);
  bool works(const EngravingInputs& inputs) const;
  void WatchProgress(const EngravingInputs& inputs);
  ChainLinks LinksNow(const EngravingInputs& inputs) const;
  std::string Question() const override { return consent_.Question(); }
  std::string TextFor(Missing missing) const override;
  /// Shutters closed, lamp off, motion braked.
  void NoteStop(bool lamp_stays) override;

  void Prepare(const EngravingInputs& inputs);
  void Wait(const EngravingInputs& inputs);
  bool MayFire(const EngravingInputs& inputs);
  bool ClocksAreKnown(const EngravingInputs& inputs);
  void BeginRun(const EngravingInputs& inputs);
  void Run(const EngravingInputs& inputs);
  void Settle(const EngravingInputs& inputs);
  void LeaveHalt(const EngravingInputs& inputs);
  void Finish();

  void Halt(const HaltReason& reason, const EngravingInputs& inputs);
  void Explain(const HaltReason& reason, intaglio_MotionFault motion_fault);
  void CheckFaultBehindSkips(const EngravingInputs& inputs);
  bool JournalIsWritten();
  void SendIdleTicks();

  EngravingJob job_;
  drivers::LaserController& laser_;
  PulseSchedule::ResultSink results_;
  PulseRecord record_;
  TickWindows ticks_;
  TickHorizon horizon_;
  MachinePreparation preparation_;
  Shutters shutters_;
  EngravingRun run_;
  Settling settling_;
  Consent consent_;
  ProgressWatch progress_;
  Disturbances disturbances_;
  bool laser_was_up_ = false, motion_was_up_ = false;

  Phase phase_ = Phase::kPreparing;
  bool granted_ = false;  // by the newest permission
  std::string motion_message_;
  bool lamp_stays_ = false;
  bool waits_for_late_ = false;  // for a permission or a state, within a run
};

}  // namespace intaglio::synchronizer
