#pragma once

// Whether a pulse is allowed: one state machine, pure. Every link has to hold and be
// fresh; if one is missing, nothing is fired:
//
//   operator's arm (this job, this epoch, fresh, not spent) -> no emergency stop on the
//   bus -> laser line up -> key on -> door closed -> stop released -> inputs of the
//   profile as it needs them -> no safe state -> lamp on and warm -> motion state fresh,
//   no fault -> block at the job's place -> [shutters open -> door locked]
//
// Each arm by a person is a grant with a number of its own, greater than those before. It
// is spent when key, door, a stop or an input opens, also before the first run, and by
// every fault of a run. A spent grant is void, however often it is repeated and whatever
// was withdrawn in between: only a greater one counts. The loss of a line or of a
// neighbouring process spends only the grant's renewal, which the job service may replace
// by a greater one by itself, unless an interlock is open meanwhile (IsLostLine). What a
// controller reports of itself is never a lost line: a stop of its own (hold, alarm,
// limit, error) is counted among the openings, and a reset is another power-up, so the
// machine watch spends the grant. A grant older than the newest one received, granted or
// withdrawn, is void.
//
// The chain exists as long as the process, and is updated from the moment a job is given
// to it: an arm may come long before the path, and what is opened in between spends it.
// So does every event that the machine watch reports (machine_watch.h): an opening that
// was not observed, a power cycle of the laser controller, a controller that was away for
// too long. An event before the first grant of a job is known counts against that grant.
//
// clang-format off
//             an interlock is open, or a fault: the newest grant is spent
//         +------------------------------------------------------------+
//         |                                                            v
//     +--------+      a greater grant, every interlock held       +----------+
//     | kClear | <----------------------------------------------- | kLatched |
//     +--------+                                                  +----------+
//         ^                                                          |  ^  |  ^
//         |  every interlock held          a greater number, only    |  |  +--+ a greater
//         |                                the machine's stop open   |  |  grant, another
//         |                               +------------+             |  |  interlock open:
//         +------------------------------ | kResetting | <-----------+  |  it is spent, too
//                                         +------------+                |
//                                               +-----------------------+
//      longer than kResetTime (the button is still pressed), another interlock open, the
//      line down, a fault, or the grant withdrawn: it is spent
// clang-format on
//
// Interlocks: the stop on the bus always; key, door, the machine's stop and the inputs
// that its profile names as the line reports them: kClear is not reached while the line
// is down. The machine keeps its stop latched until it is reset, which is allowed in
// kResetting, and, for a safe state, in kClear: an arm includes the consent to this
// reset. So does the release of a stop on the bus by a person, which grants nothing
// (services/synchronizer/laser_stop.h).

#include <chrono>
#include <compare>
#include <cstdint>
#include <string>

#include "services/cell/machine_watch.h"

namespace intaglio::cell {

/// Ordered by number, then by renewal.
struct Grant {
  std::uint64_t number = 0;   ///< of the person's arm; 0: none yet
  std::uint64_t renewal = 0;  ///< greater each time it was renewed without a person
  auto operator<=>(const Grant&) const = default;
};

struct ChainLinks {
  bool permission_fresh = false;
  bool permission_granted = false;
  Grant grant;                    ///< newest of this job, granted or withdrawn
  bool stop_not_pressed = false;  ///< no EmergencyStop on the bus
  bool laser_line_up = false;
  bool key_on = false;
  bool door_closed = false;
  bool stop_released = false;  ///< the machine's own button
  bool inputs_hold = true;     ///< that the profile names, or it names none
  bool no_safe_state = false;
  bool lamp_sync_counted = false;
  bool lamp_warm = false;
  bool motion_fresh = false;
  bool motion_without_fault = false;
  /// Whoever has the line to the motion controller answers, and says that the line is
  /// down: a fault that passes, and an absence of the controller all the same.
  bool motion_line_down = false;
  /// The stage that carries the block is where the job needs it, or there is none.
  bool block_at_place = true;
  bool shutters_open = false;
  bool door_locked = false;  ///< or the machine has no lock
  MachineCounters counters;  ///< of the laser controller, while its line is up
  // The newest state is older than its lease, and nothing shows that the line, or the
  // process that has it, was lost: so the link itself (laser_line_up, motion_fresh) does
  // not hold. True only of a machine whose time is simulated and waits.
  bool laser_late = false, motion_late = false;
};

enum class Missing : std::uint8_t {
  kNothing,
  kPermission,
  kEmergencyStop,
  kLaserLine,
  kChain,  ///< key, door and stop, which are one input of the machine
  kKey,
  kDoor,
  kInput,
  kSafeState,
  kLampSync,
  kLamp,
  kMotionState,
  kMotionFault,
  kBlockPlace,
  kShutter,
  kDoorLock,
  // Never a missing link: reasons why a grant was spent (UnseenEvent).
  kOpenedUnseen,
  kPowerCycle,
  kNotWatched,
  kLaserAway,
  kMotionAway,
};

/// A reason why a grant was spent that no link shows.
constexpr bool IsUnseen(Missing missing) { return missing >= Missing::kOpenedUnseen; }

/// The first link that does not hold by itself, whatever is spent. Shutters, and the lock
/// that holds the door while one is open, are checked when `with_shutters`, which a
/// caller that is about to arm sets: they open when all other links hold.
Missing FirstMissing(const ChainLinks& links, bool with_shutters);

/// Only a line, or the process that has it, was lost: a renewal of the grant suffices.
/// `late_motion`: a kMotionFault is of a line that is down or was too slow, not of the
/// controller. A safe state is that of a controller that received nothing from its host
/// for too long: one that it enters for a reason of its own is counted among the openings
/// in the same status, which spends the grant before this is asked.
constexpr bool IsLostLine(Missing missing, bool late_motion) {
  return missing == Missing::kLaserLine || missing == Missing::kMotionState ||
         missing == Missing::kSafeState ||
         (missing == Missing::kMotionFault && late_motion);
}

/// What to do about it, in one sentence; empty for kNothing.
std::string TextOf(Missing missing);

class PermissionChain {
 public:
  enum class State : std::uint8_t { kClear, kLatched, kResetting };
  /// The machine answers a Reset with a status within 20 ms, a loaded computer later.
  static constexpr std::chrono::milliseconds kResetTime{500};

  /// Another job: grants are numbered by job. What is known about the machine is kept.
  void BeginJob();
  /// The job was begun by another process, which left these counters in the journal;
  /// none, if it is not known what happened at the machine since the job was armed.
  void TakeUp(const MachineCounters& counters) { watch_.Expect(counters); }
  /// Between two jobs: keeps what is known of the machine up to date.
  void Watch(const ChainLinks& links, std::chrono::nanoseconds now);
  /// Once a turn, before anything is asked. What spent a grant in this turn, or kNothing.
  Missing Turn(const ChainLinks& links, std::chrono::nanoseconds now);
  /// A fault of a run: the grant it ran with is spent. `only_renewal`: a line or a
  /// neighbouring process was lost, and a renewal of the grant suffices. `by`: the link
  /// that was missing; kNothing: it was none.
  void Latch(bool only_renewal, Missing by = Missing::kNothing);

  /// What keeps a pulse from being fired; kNothing: it may be. kPermission when all links
  /// hold and the grant is spent.
  Missing WhatIsMissing(const ChainLinks& links, bool with_shutters) const;
  State state() const { return state_; }
  bool latched() const { return state_ != State::kClear; }
  /// Latched, and a grant was spent.
  bool has_spent() const { return latched() && spent_.number > 0; }
  /// What spent a grant last, of this job: kNothing when it was no link.
  Missing spent_by() const { return spent_by_; }
  const MachineCounters& counters() const { return watch_.counters(); }
  /// No renewal of this one counts any more, but a greater number alone.
  bool has_lost(const Grant& grant) const;
  /// The newest grant holds, is fresh and not spent: what comes with a job, motion to its
  /// place and the lamp, may begin. The links of the machine are not asked.
  bool has_grant(const ChainLinks& links) const;
  /// The machine may be commanded to leave its safe state and its latched stop.
  bool may_reset(const ChainLinks& links) const;

 private:
  void Spend();
  bool HasWorth() const;
  Missing CheckForUnseenEvent(const ChainLinks& links, std::chrono::nanoseconds now);
  Missing AdvanceState(const ChainLinks& links, std::chrono::nanoseconds now);
  /// Not a grant from before the newest, repeated by a sender that was away meanwhile.
  bool IsNewest(const ChainLinks& links) const { return links.grant >= grant_; }
  bool IsNewestGranted(const ChainLinks& links) const;

  State state_ = State::kClear;
  Grant grant_;  // the newest
  Grant spent_;  // this and all before it
  Missing spent_by_ = Missing::kNothing;
  Missing before_first_grant_ = Missing::kNothing;  // an event that it will be spent by
  MachineWatch watch_;
  std::chrono::nanoseconds resetting_since_{0};
};

}  // namespace intaglio::cell
