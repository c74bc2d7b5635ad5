#pragma once

// Makes the points of one job: decides every tick ahead, and takes every result.
//
//             laser up, motion state        chain whole, points open
//   kPreparing ------------------> kWaiting ------------------------> kRunning
//       lamp on, warms up          ^  ^  | nothing left                  |  |
//                                  |  |  +--> kDone                      |  | all sent,
//                                  reported, |  +----------------------------------+  |
//                                  at rest: next pass |                    (pass
//                                  finished)     | | | a link of the chain lost
//                                  +--- all armed settled, at rest --- kHalting
//
// A run is a pass over the open points from rest to rest, as far as they are made in the
// same channels: shutters are moved between runs. kHalting takes back what has
// not fired (Disarm), brakes the stage and closes the shutters, then settles every armed
// point: by report, by what the controller remembers when reports were lost, or, after
// another power-up of it, as uncertain. It is not left before the controller has said
// that nothing is armed, and its counter was looked at if the line was lost. A job that
// an earlier life left begins there.
// After a fault (anything but a withdrawn permission) only a new grant counts: nothing
// restarts by itself (permission_chain.h). So it is, if the job says so, when points are
// left of which nobody knows whether they were fired, even if nothing else is left.
//
// No pulse without: an intent on disk, the motion for its tick in the controller, and
// the whole permission chain at the moment of arming. Used from one thread; no waits.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "services/synchronizer/engraving/consent.h"
#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/engraving/shutters.h"
#include "services/synchronizer/engraving_inputs.h"
#include "services/synchronizer/motion_feed.h"
#include "services/synchronizer/permission/permission_chain.h"
#include "services/synchronizer/pulses/laser_controller.h"
#include "services/synchronizer/pulses/open_points.h"
#include "services/synchronizer/pulses/pulse_record.h"
#include "services/synchronizer/pulses/pulse_schedule.h"
#include "services/synchronizer/pulses/tick_clock.h"

namespace intaglio::synchronizer {

class Engraving {
 public:
  enum class Phase { kPreparing, kWaiting, kRunning, kHalting, kDone };

  /// `chain` has been told of the job, and is turned by this from now on.
  Engraving(EngravingJob job, LaserController& laser, MotionFeed& feed,
            JournalWriter& journal, PermissionChain& chain,
            PulseSchedule::ResultSink results);

  void Turn(const EngravingInputs& inputs);
  /// The controller's report, as LaserController::Poll hands it over.
  void Take(const link::PulseReport& report);
  void Take(const link::PastReport& report);
  /// Shutters closed, lamp off, motion braked; what is armed is settled over the next
  /// turns, or left open in the journal when the line stays down. For cancelled jobs and
  /// the end of the process; `lamp_stays` for a job that will be taken up again.
  void Stop(const std::string& why, bool lamp_stays = false);

  Phase phase() const { return phase_; }
  const PointLedger& ledger() const { return record_.ledger(); }
  /// What it waits for or why it halted; empty while all is well.
  const std::string& message() const { return message_; }
  /// Halted by a fault, not by a withdrawn permission: the grant is spent.
  bool faulted() const { return chain_.has_spent(); }
  /// What was lost is a line or a neighbour, not the machine's safety: it may be resumed
  /// without anybody walking to the machine.
  bool lost_a_line() const { return lost_a_line_; }
  bool started() const { return run_count_ > 0 || taken_up_; }
  /// Of points that nobody knows of, and nobody has answered yet.
  bool asks() const { return consent_.asks(); }
  /// It fires nothing until somebody or something outside lets it.
  bool waits() const {
    const bool begun = started() || faulted() || (granted_ && !job_.block_misfit.empty());
    return begun && phase_ != Phase::kRunning && !starts_again_ && !message_.empty();
  }
  std::uint32_t run_count() const { return run_count_; }
  std::uint64_t first_fired_tick() const { return record_.first_fired_tick(); }
  std::uint64_t last_fired_tick() const { return record_.last_fired_tick(); }
  /// Least speed override that motion was planned with, and how often it changed.
  std::uint32_t least_speed_percent() const { return least_speed_percent_; }
  std::uint32_t speed_changes() const { return speed_changes_; }
  /// Points made that no report told of, but the controller's memory.
  std::uint64_t settled_by_memory() const { return settled_by_memory_; }

 private:
  ChainLinks LinksNow(const EngravingInputs& inputs) const {
    return LinksOf(inputs, laser_, shutters_.run_mask());
  }
  std::uint64_t TickNow(const EngravingInputs& inputs) const;
  std::uint64_t AheadTicks() const;
  bool MotionClockSettles(const EngravingInputs& inputs);
  void TakeSpeed(const EngravingInputs& inputs);
  void FeedMotion(const EngravingInputs& inputs);

  void Prepare(const EngravingInputs& inputs);
  std::string WhatPreparationWaitsFor(const EngravingInputs& inputs);
  void LeaveSafeState(const EngravingInputs& inputs);
  void LightLamp(const EngravingInputs& inputs);
  void TurnChain(const EngravingInputs& inputs);
  void HaltOverOtherDevice(const EngravingInputs& inputs);
  void Await(const EngravingInputs& inputs);
  void AskOverUncertain(const EngravingInputs& inputs);
  bool NothingIsLeft(const EngravingInputs& inputs) const;
  bool JournalIsWritten();
  ChannelMask MaskOfNextRun();
  void StartRun(const EngravingInputs& inputs);
  void Run(const EngravingInputs& inputs);
  void DecideTicks(const EngravingInputs& inputs);
  bool Prearm(std::uint64_t first, std::uint64_t last);
  void SendDurableWindows();
  void FinishRun();
  void Halt(Missing missing, const std::string& text, bool fault);
  void Explain(Missing missing, const std::string& text, bool fault);
  void HaltOverSkipped();
  void HaltOverMissed();
  void LookForFaultBehindSkips(const EngravingInputs& inputs);
  void SettleHalted(const EngravingInputs& inputs);
  bool AskToDisarm();
  void HearDisarmed();
  void TakeUp();
  void AbortEarlierRun(const EngravingInputs& inputs);
  void SettleByMemory(bool late);
  void AskForThePast();
  void CompareCounters();
  bool DoubtNextPoints();
  void SettleAs(std::vector<PulseResult> points, formats::PointOutcome outcome);
  void AwaitShutter(const EngravingInputs& inputs);
  void KeepIdleTicksPassing();
  void Note(const PulseResult& result);
  void NoteInRun(const PulseResult& result);
  void Finish();

  // Of what is asked for until it is answered.
  static constexpr std::chrono::milliseconds kRequestPeriod{20};
  // Passes over points that were skipped, as long as a pass makes at least one.
  static constexpr int kMaxIdleRuns = 2;

  struct Window {
    std::uint64_t journal_number = 0;  // sent once this many records are durable
    link::ArmWindow arm;
  };

  EngravingJob job_;
  LaserController& laser_;
  MotionFeed& feed_;
  PermissionChain& chain_;
  PulseSchedule::ResultSink results_;
  PulseRecord record_;
  OpenPoints open_points_;
  PulseSchedule schedule_;
  std::deque<Window> windows_;
  Shutters shutters_;
  Consent consent_;

  Phase phase_ = Phase::kPreparing;
  std::string message_;
  bool granted_ = false, grant_heard_ = false;  // by the newest word; of this job
  bool starts_again_ = false;  // of its own accord, after a run that began too late
  bool lost_a_line_ = false;
  bool stopping_ = false;
  bool lamp_stays_ = false;
  bool taken_up_ = false;  // from an earlier life
  std::uint32_t run_count_ = 0;
  bool passed_by_ = false;  // a point of this run was reached and not fired
  SkipReason passed_by_reason_ = SkipReason::kNone;
  std::uint64_t passed_by_tick_ = 0;
  std::uint64_t ended_before_run_ = 0;
  int idle_runs_ = 0;
  int fruitless_runs_ = 0;
  std::uint32_t missed_in_a_row_ = 0;  // in this run
  int late_starts_ = 0;
  std::uint32_t speed_percent_ = 100;  // of the motion planned last
  std::uint32_t least_speed_percent_ = 100;
  std::uint32_t speed_changes_ = 0;
  bool own_clock_ = false;  // of the motion controller, in this run
  std::uint32_t clock_steps_ = 0;
  std::uint64_t decided_ = 0;  // by us, sent or about to be
  std::uint64_t sent_through_ = 0;
  std::uint64_t reported_through_ = 0;
  std::uint64_t session_ = 0;
  std::uint32_t doubts_left_ = 0;  // pulses that may have made the next open points
  std::uint64_t uncertain_before_halt_ = 0;
  std::uint64_t settled_by_memory_ = 0;
  std::chrono::nanoseconds now_{0};
  intaglio_MotionFault motion_fault_ = intaglio_MOTION_OK;
  std::chrono::nanoseconds halted_at_{0};
  SkipReason skip_reason_ = SkipReason::kNone;
  std::uint64_t disarm_session_ = 0;
  bool disarm_asked_ = false;
  bool disarm_seen_ = false;
  TickClock clock_;
  std::pair<std::uint64_t, std::uint64_t> status_number_{0, 0};  // session, number
  std::chrono::nanoseconds next_request_{0}, next_past_{0}, next_abort_{0};
  std::uint64_t lamp_session_ = 0;
};

}  // namespace intaglio::synchronizer
