#include "services/synchronizer/permission_chain.h"

namespace intaglio::synchronizer {

Missing FirstMissing(const ChainLinks& links, bool with_shutters) {
  if (!links.permission_fresh || !links.permission_granted) return Missing::kPermission;
  if (!links.stop_not_pressed) return Missing::kEmergencyStop;
  if (!links.laser_line_up) return Missing::kLaserLine;
  if (!links.key_on) return Missing::kKey;
  if (!links.door_closed) return Missing::kDoor;
  if (!links.stop_released) return Missing::kEmergencyStop;
  if (!links.no_safe_state) return Missing::kSafeState;
  if (!links.lamp_warm) return Missing::kLamp;
  if (!links.motion_fresh) return Missing::kMotionState;
  if (!links.motion_without_fault) return Missing::kMotionFault;
  if (with_shutters && !links.shutters_open) return Missing::kShutter;
  return Missing::kNothing;
}

std::string TextOf(Missing missing) {
  switch (missing) {
    case Missing::kNothing:
      return "";
    case Missing::kPermission:
      return "waits for the operator's arm (intaglio resume JOB)";
    case Missing::kEmergencyStop:
      return "emergency stop is pressed: release and reset it, then resume";
    case Missing::kLaserLine:
      return "the laser line is down: check the cable and the controller, then resume";
    case Missing::kKey:
      return "the key switch is off: turn it on, then resume";
    case Missing::kDoor:
      return "the door is open: close it, then resume";
    case Missing::kSafeState:
      return "the laser controller is in its safe state: resume to reset it";
    case Missing::kLamp:
      return "the lamp is not warm yet";
    case Missing::kMotionState:
      return "the motion bridge is silent: see that intaglio-motion-bridge runs, then "
             "resume";
    case Missing::kMotionFault:
      return "the stage reports a fault";
    case Missing::kShutter:
      return "the shutter does not open: check its drive, then resume";
  }
  return "";
}

}  // namespace intaglio::synchronizer
