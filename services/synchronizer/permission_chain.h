#pragma once

// Whether a pulse is allowed. Every link has to hold, all fresh; one missing is enough.
//
//   operator's arm (this job, this epoch, fresh) -> no emergency stop on the bus ->
//   laser line up -> key on -> door closed -> stop released -> no safe state ->
//   lamp on and warm -> motion state fresh, no fault -> [shutters open]
//
// The last link is asked for only by whoever is about to arm: the shutters open when
// all the others hold.

#include <cstdint>
#include <string>

namespace intaglio::synchronizer {

struct ChainLinks {
  bool permission_fresh = false;
  bool permission_granted = false;
  bool stop_not_pressed = false;  ///< no EmergencyStop on the bus
  bool laser_line_up = false;
  bool key_on = false;
  bool door_closed = false;
  bool stop_released = false;  ///< the machine's own button
  bool no_safe_state = false;
  bool lamp_warm = false;
  bool motion_fresh = false;
  bool motion_without_fault = false;
  bool shutters_open = false;
};

enum class Missing : std::uint8_t {
  kNothing,
  kPermission,
  kEmergencyStop,
  kLaserLine,
  kKey,
  kDoor,
  kSafeState,
  kLamp,
  kMotionState,
  kMotionFault,
  kShutter,
};

/// The first link that does not hold; shutters are looked at when `with_shutters`.
Missing FirstMissing(const ChainLinks& links, bool with_shutters);

/// What to do about it, in one sentence; empty for kNothing.
std::string TextOf(Missing missing);

}  // namespace intaglio::synchronizer
