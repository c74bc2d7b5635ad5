#pragma once

// What happens at a controller while a host runs it: the rows of the three conformance
// suites. Each is inflicted at three instants: before a run, in it, and at rest behind
// it; of what moves by hand also in a jog.

#include <array>

namespace intaglio::drivers {

enum class ControllerFault {
  kPowerCycle,
  kReset,          ///< by its own button
  kEmergencyStop,  ///< at the controller, and released
  kHold,           ///< feed hold, and released
  kLimit,          ///< a limit switch
  kAlarm,          ///< of a drive, or the controller's own
  kError,          ///< it refuses what it was sent
  kUnplug,         ///< the cable, and plugged in again
};

inline constexpr std::array kControllerFaults = {
    ControllerFault::kPowerCycle,    ControllerFault::kReset,
    ControllerFault::kEmergencyStop, ControllerFault::kHold,
    ControllerFault::kLimit,         ControllerFault::kAlarm,
    ControllerFault::kError,         ControllerFault::kUnplug};

constexpr const char* NameOf(ControllerFault fault) {
  constexpr std::array kNames = {"power_cycle", "reset", "emergency_stop", "hold",
                                 "limit",       "alarm", "error",          "unplug"};
  return kNames[static_cast<std::size_t>(fault)];
}

enum class FaultInstant { kBeforeTheRun, kInTheRun, kBehindTheRun, kInAJog };

inline constexpr std::array kFaultInstants = {
    FaultInstant::kBeforeTheRun, FaultInstant::kInTheRun, FaultInstant::kBehindTheRun};
inline constexpr std::array kMotionFaultInstants = {
    FaultInstant::kBeforeTheRun, FaultInstant::kInTheRun, FaultInstant::kBehindTheRun,
    FaultInstant::kInAJog};

constexpr const char* NameOf(FaultInstant instant) {
  constexpr std::array kNames = {"before_the_run", "in_the_run", "behind_the_run",
                                 "in_a_jog"};
  return kNames[static_cast<std::size_t>(instant)];
}

}  // namespace intaglio::drivers
