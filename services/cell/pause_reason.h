#pragma once

// Why an engraving is paused, for programs that decide about it over the bus. The
// sentence for people is in the message beside it.

#include "idl/job.h"
#include "services/cell/permission_chain.h"

namespace intaglio::cell {

/// Why a grant paused that was spent by this; kNothing: by a fault of a run.
constexpr intaglio_PauseReason PauseReasonOf(Missing spent_by) {
  switch (spent_by) {
    case Missing::kEmergencyStop:
      return intaglio_PAUSE_EMERGENCY_STOP;
    case Missing::kChain:
    case Missing::kKey:
    case Missing::kDoor:
    case Missing::kInput:
    case Missing::kOpenedUnseen:
      return intaglio_PAUSE_INTERLOCK;
    case Missing::kPowerCycle:
    case Missing::kNotWatched:
    case Missing::kLaserAway:
    case Missing::kMotionAway:
      return intaglio_PAUSE_MACHINE_CHANGED;
    default:
      return intaglio_PAUSE_FAULT;
  }
}

struct PausedEngraving {
  bool faulted = false;      ///< its grant is spent
  bool lost_a_line = false;  ///< only for its renewal: it may go on by itself
  bool asks = false;         ///< about uncertain points
  Missing spent_by = Missing::kNothing;
};

constexpr intaglio_PauseReason PauseReasonOf(const PausedEngraving& paused) {
  if (!paused.faulted) return intaglio_PAUSE_NOT_ARMED;
  if (paused.lost_a_line) return intaglio_PAUSE_LINE_LOST;
  if (paused.asks) return intaglio_PAUSE_UNCERTAIN_POINTS;
  return PauseReasonOf(paused.spent_by);
}

}  // namespace intaglio::cell
