#pragma once

// What became of the pulses of one job. The ledger, the journal and the listener get
// every change from here alone, so they never disagree:
//
//   Arm         ledger: armed        journal: intent         (the point may fire once the
//   Resolve     ledger: the outcome  journal: outcome         intent is durable)
//   LeaveOut..  ledger: left out     journal: outcome
//   Mark..      ledger: uncertain    journal: outcome
//   Reopen      ledger: planned      journal: reopened, by a consent already there
//
// It also keeps the account of the laser controller's pulse counter, modulo 2^32: what it
// counted before the job, and what it fired for it. A session record has the power-up of
// the controller and the first of these counts, for the process that takes the job up.
//
// Used from one thread. Nothing here waits, locks or writes to the disk; JournalWriter's
// ring does the rest. Where a function returns bool, false means that the ring is full
// and nothing has changed: call it again in a later turn.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "services/cell/consent.h"
#include "services/cell/earlier_work.h"
#include "services/cell/journal_writer.h"
#include "services/cell/point_ledger.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/fired_ticks.h"
#include "services/synchronizer/pulses/pulse_schedule.h"

namespace intaglio::synchronizer {

class PulseRecord final : public cell::UncertainPoints {
 public:
  /// `photosensor_feedback`: false when nothing sees cracks; then what was fired counts
  /// as made. `results` gets what became of each point, after ledger and journal.
  PulseRecord(std::size_t point_count, bool photosensor_feedback, JournalWriter& journal,
              PulseSchedule::ResultSink results);

  /// Begins with what earlier lives left. Returns the points whose intent is open, in the
  /// order of their ticks: they are armed in the ledger, and the caller has to settle
  /// them.
  std::vector<PulseResult> TakeUp(const EarlierWork& earlier);

  const PointLedger& ledger() const override { return ledger_; }
  /// Made or missed so far.
  std::uint64_t fired_point_count() const {
    return ledger_.count(PointState::kMade) + ledger_.count(PointState::kMissed);
  }

  /// The run that records belong to; 0: none has begun, in any life.
  std::uint32_t run() const { return run_; }
  /// Run numbers up to this one are in use.
  void SkipRuns(std::uint32_t highest_run) { run_ = std::max(run_, highest_run); }
  /// An earlier life may have sent a run of which nothing was armed, so that no record
  /// has its number, and which the stage has not shown yet: ours gets another one.
  void BeginRun() { run_ += 1 + std::exchange(unrecorded_runs_, 0); }

  /// Its intent. False: the ring is full; the ledger has it armed all the same, and it
  /// must not be sent.
  bool Arm(std::uint64_t tick, std::uint32_t point);
  /// What became of an armed point. kUncertain with SkipReason::kPosition: it was fired
  /// at a place that is not known.
  void Resolve(PulseResult result);
  /// An open point that the controller may have fired: for a life whose records are lost
  /// (kLink), or in place of another (kPosition).
  bool MarkUncertain(std::uint32_t point, SkipReason reason = SkipReason::kLink);
  /// Every open point before `point`, for good: each later life reads it in the journal.
  bool LeaveOutBefore(std::uint32_t point);
  /// A person's consent to fire uncertain points again, by the number of its grant.
  bool KeepConsent(std::uint64_t grant_number) override;
  /// An uncertain point may be fired again, by that consent.
  bool Reopen(std::uint32_t point, std::uint64_t grant_number) override;

  /// The controller's power-up that the account is of; 0: none yet.
  std::uint32_t power_up() const { return power_up_; }
  /// What its counter shows when every pulse is known.
  std::uint32_t known_pulse_count() const { return pulses_before_job_ + fired_count_; }
  /// Begins the account anew with the controller's counter as it is now. With nothing
  /// armed: else the pulses of uncertain points would be taken for some of the next lost
  /// line.
  void TakeCounters(const drivers::LaserController& laser);
  /// Openings of interlocks that a run is begun in spite of: what later lives need not
  /// ask about.
  void AcceptOpenings(const drivers::LaserController& laser, std::uint32_t openings);

  /// The controller has counted pulses that known_pulse_count leaves out: TakeCounters is
  /// due when nothing is armed.
  bool leaves_out_pulses() const { return leaves_out_pulses_; }

  /// The ticks that all lives fired at.
  const FiredTicks& fired_ticks() const { return fired_ticks_; }

  /// Everything appended so far is on disk.
  bool is_durable() const { return journal_.durable() == journal_.appended(); }
  std::uint64_t appended() const { return journal_.appended(); }
  std::uint64_t durable() const { return journal_.durable(); }
  bool disk_failed() const { return journal_.failed(); }
  std::string disk_error() const { return journal_.error(); }
  void Flush() { journal_.Flush(); }
  /// Flushes what was appended since the last call.
  void FlushAppended();

 private:
  void JournalSession(const drivers::LaserController& laser);

  JournalWriter& journal_;
  PulseSchedule::ResultSink results_;
  bool photosensor_feedback_;
  PointLedger ledger_;
  std::uint32_t run_ = 0;
  std::uint32_t unrecorded_runs_ = 0;
  std::uint32_t left_out_before_ = 0;
  bool session_journaled_ = false;
  std::uint32_t power_up_ = 0;
  std::uint32_t pulses_before_job_ = 0;
  std::uint32_t fired_count_ = 0;
  bool leaves_out_pulses_ = false;
  std::uint32_t openings_accepted_ = 0;
  FiredTicks fired_ticks_;
  std::uint64_t flushed_ = 0;
};

}  // namespace intaglio::synchronizer
