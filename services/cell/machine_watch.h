#pragma once

// Whether the machine was unobserved: what its controllers' own counters, and their
// silence, show about the time in which key, door and stop button could not be seen.
//
// The laser controller draws a number at each power-up and counts since then how often an
// interlock was opened. A different number of either, compared with the one known before,
// is an event, also after a lost line or in another life of this process. So is a
// controller whose silences together exceed host::kMaxAbsence (host::AbsenceSum). Every
// event costs the arm that was given before it (permission_chain.h). Pure; used from one
// thread.

#include <chrono>
#include <cstdint>

#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::cell {

/// Counters of the laser controller.
struct MachineCounters {
  std::uint32_t power_up = 0;  ///< drawn at power-up; 0: not known
  std::uint32_t openings = 0;  ///< of the interlocks, since that power-up
  bool operator==(const MachineCounters&) const = default;
};

enum class UnseenEvent : std::uint8_t {
  kNone,
  kOpened,      ///< key, door or stop button was opened and is closed again
  kPowerCycle,  ///< the laser controller was switched off and on
  kNotWatched,  ///< no counter from before is known to compare with
  kLaserAway,   ///< the laser controller is silent for longer than the limit
  kMotionAway,  ///< the motion controller is
};

class MachineWatch {
 public:
  struct Sight {
    bool laser_line_up = false;
    bool interlocks_closed = false;  ///< key, door, stop button and inputs, by the line
    MachineCounters counters;        ///< of the laser controller, while its line is up
    bool motion_seen = false;  ///< the motion controller itself, not who has its line
  };

  /// Once a turn. An event is returned in the turn in which it is noticed; an absence in
  /// every turn as long as it lasts beyond the limit.
  UnseenEvent Update(const Sight& sight, std::chrono::nanoseconds now);
  /// The next comparison is with these, which an earlier process has left in the journal.
  void Expect(const MachineCounters& counters) { known_ = counters; }
  /// A person has armed: silences that have ended are judged by that. One that lasts is
  /// not, for who armed cannot have seen what the controller would show.
  void AcceptSilences(std::chrono::nanoseconds now);
  const MachineCounters& counters() const { return known_; }

 private:
  UnseenEvent Compare(const Sight& sight);

  MachineCounters known_;
  host::AbsenceSum laser_, motion_;
};

}  // namespace intaglio::cell
