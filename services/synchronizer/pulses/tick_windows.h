#pragma once

// Which ticks are decided, for one laser controller: the points planned for them are
// armed, and the windows are sent when their intents are on disk.
//
//   planned --Arm: intent appended--> armed, held --intent durable: Send--> sent -->
//   settled
//      ^        (the one place where             |                               by
//      result
//   schedule     a point is armed)               +--DropUnsent: never sent, never fires
//
// Ticks are decided once, in order. What was decided holds for one session of the line:
// after a Disarm or in another session it begins again (TakeDisarmed, Begin).
//
// A pulse that was fired has its result when the place of the stage at its tick is known
// to be the planned one. Until then its point stays armed; where it never becomes known,
// the point is uncertain, and so is each that its pulse may have hit instead: a stage
// that is late by some ticks is at the places of so many ticks later. What was not fired
// has its result at once. Used from one thread; nothing waits.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/pulses/pulse_record.h"
#include "services/synchronizer/pulses/pulse_schedule.h"
#include "services/synchronizer/pulses/pulse_trigger.h"

namespace intaglio::synchronizer {

class TickWindows {
 public:
  /// Both outlive this.
  TickWindows(drivers::LaserController& laser, PulseRecord& record)
      : laser_(laser), record_(record) {}

  /// What is planned and what is armed; planned points are added to it.
  PulseSchedule& schedule() { return schedule_; }
  const PulseSchedule& schedule() const { return schedule_; }

  /// With which each point is made from now on; 0: as the laser does by itself.
  void SetPulsesPerPoint(std::uint16_t count) { pulses_per_point_ = count; }
  /// A run, in the session of now: everything up to `tick`, the newest one, is decided,
  /// and what the controller has decided already. `lockstep`: idle ticks that are still
  /// on their way, too.
  void Begin(std::uint64_t tick, bool lockstep);
  /// Ticks up to this one have passed undecided.
  void SkipTo(std::uint64_t tick) { decided_ = std::max(decided_, tick); }
  /// Decides the ticks that follow, through `last`: what is planned for them is armed, in
  /// ledger, journal and window. `late` gets points whose tick is decided already. False
  /// when an intent does not get to the journal: then that window and what follows it are
  /// not sent, ever. The pulse of a point has `energy_mj_of` it; a window has one energy,
  /// so it ends where the energy changes. `trigger` marks the windows.
  bool Arm(std::uint64_t last,
           const std::function<double(std::uint32_t point)>& energy_mj_of,
           const std::function<void(std::uint32_t point)>& late,
           const PulseTrigger& trigger = TriggerAtTick());
  /// Sends the windows whose intents are on disk, as far as the line takes them.
  void SendDurable();
  /// Lockstep, with nothing armed: decides `count` ticks that fire nothing when the
  /// machine has come to the end of what was decided.
  void SendIdle(std::size_t count);

  /// The controller's results; what was not armed here is passed over.
  void Receive(const link::PulseReport& report);
  void Receive(const link::PastReport& report);

  /// Through which tick the places of this run are known; UINT64_MAX, as at first: all.
  /// `late_ticks`: how much later the stage is at the places of the others, as far as it
  /// is known.
  void SetCertain(std::uint64_t through, double late_ticks);
  /// No other tick of this run becomes certain. Once a turn from then on.
  void LosePlaces();
  bool has_lost_places() const { return lost_places_; }
  /// Fired points wait for SetCertain or LosePlaces.
  bool awaits_places() const { return !unplaced_.empty() || marks_owed_; }

  /// Forgets what is planned and what is held; returns the armed points of windows that
  /// were never sent.
  std::vector<PulseResult> DropUnsent();
  /// Disarmed: what the controller has decided by its status, and no more, is decided.
  void TakeDisarmed() { decided_ = laser_.status().decided_through; }

  std::uint64_t decided() const { return decided_; }
  std::uint64_t reported_through() const { return reported_through_; }
  /// Windows wait for the journal's disk or for the line.
  bool holds_windows() const { return !held_.empty(); }
  /// Another session than the one that ticks were decided in.
  bool session_lost() const { return laser_.session() != session_; }

 private:
  bool ArmOne(std::uint64_t last, double pulse_energy_mj,
              const std::function<void(std::uint32_t point)>& late,
              const PulseTrigger& trigger);

  void Resolve(const PulseResult& result);
  void MarkHit();

  struct HeldWindow {
    std::uint64_t journal_number = 0;  // sent once this many records are durable
    link::ArmWindow arm;
  };

  drivers::LaserController& laser_;
  PulseRecord& record_;
  PulseSchedule schedule_;
  std::deque<HeldWindow> held_;
  std::uint64_t decided_ = 0;  // sent or held
  std::uint64_t sent_through_ = 0;
  std::uint64_t reported_through_ = 0;
  std::uint64_t session_ = 0;
  std::uint16_t pulses_per_point_ = 0;
  std::uint64_t certain_through_ = UINT64_MAX;
  bool lost_places_ = false;
  double late_ticks_ = 0;
  std::vector<PulseResult> unplaced_;  // fired, in the order of their reports
  std::uint64_t last_unplaced_ = 0;    // tick that was fired at an unknown place
  std::vector<PulseResult> others_;    // of ticks that are not certain, not fired
  bool marks_owed_ = false;            // the journal's ring was full
};

}  // namespace intaglio::synchronizer
