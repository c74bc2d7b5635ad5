#pragma once

// The messages of the laser line, between a synchronizer (host) and a laser controller
// (device). Each struct is the payload of one frame (services/platform/link/frame.h); all
// numbers little endian, packed in the order of the fields; docs/protocols.md shows the
// bytes.
//
// The controller counts lamp sync pulses, "ticks", from its power-up. The host decides
// every tick ahead, in windows that follow each other without gap: fire or not. An
// undecided tick does not fire. When `gated` is set, an armed tick fires only if the
// motion controller's in-position output is on at that tick: it is on when a segment that
// ends at exactly this tick is marked for a pulse and the stage is within the machine's
// position tolerance of its end. So two lines have to agree on a tick.
//
// When `at_place` is set, too, the pulse of an armed tick comes not at its lamp sync but
// at the motion controller's compare output, which is on for an instant while the tick
// lasts: when the stage passes nearest to the end of that segment, within the tolerance.
//
// The laser has inputs and outputs of its own: lamp sync, Q-switch, photosensor and
// shutter of each channel. Their timing is the host's to command (PulseTiming).
//
// Outputs and inputs for other uses (air, extraction, a clamp) are the controller's, too.
// An output is on from a command to the next safe state, opening of an interlock, or
// session, so that no lost host leaves it on. An input that the host has named is an
// interlock: the controller fires nothing while it is not as commanded. A controller
// that has none sends no AccessoryState.
//
// A window carries the energy of its pulses, so no lost frame and no earlier command
// decides it: a laser that cannot make it makes none.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "services/platform/link/message.h"

namespace intaglio::link {

enum class LaserFrame : std::uint8_t {
  // host -> device
  kLampCommand = 0x10,
  kShutterCommand = 0x11,
  kArmWindow = 0x12,
  kDisarm = 0x13,      ///< no payload: undecides every tick that has not passed
  kLaserStop = 0x14,   ///< no payload: emergency stop; latched until kLaserReset
  kLaserReset = 0x15,  ///< no payload: leaves the safe state when its cause is gone
  kLaserStatusRequest = 0x16,  ///< no payload
  kPastRequest = 0x17,
  kPulseTiming = 0x18,
  kAccessoryCommand = 0x19,
  // device -> host
  kLaserIdentity = 0x20,  ///< once after every handshake
  kLaserStatus = 0x21,    ///< on request, on every change of an interlock, every 20 ms,
                          ///< at rest 40 ms
  kPulseReport = 0x22,
  kPastReport = 0x23,  ///< the answer to every kPastRequest
  /// Behind the identity, and on every change, before what it decided about.
  kAccessoryState = 0x24,
};

struct LampCommand {
  bool on = false;
  double rate_hz = 0;  ///< lamp sync rate, one of the controller's rates
};

struct ShutterCommand {
  std::uint8_t open_mask = 0;  ///< bit 0..3: channels 1..4
};

/// How the controller drives the laser, until power-off or the next one. Defaults: what
/// it does without (Trochimczuk 2008, annexes C and D: a trigger within 20 us of the lamp
/// sync, longer than 100 us; a sync longer than 2 us; a sensor's signal longer than 10
/// us).
struct PulseTiming {
  double qswitch_delay_us = 5;      ///< from the lamp sync to the trigger
  double qswitch_width_us = 120;    ///< of the trigger
  double min_sync_width_us = 2;     ///< a lamp sync that is not longer is not counted
  double min_sensor_width_us = 10;  ///< nor is a photosensor's signal
  double shutter_time_ms = 0;       ///< no trigger so long after a shutter was commanded
  /// A flash below or above these heights is not counted; glass frame.
  double min_flash_height_mm = -1e4, max_flash_height_mm = 1e4;
};
inline constexpr double kMaxPulseTime_us = 1e4, kMaxShutterTime_ms = 1e3,
                        kMaxFlashHeight_mm = 1e4;

/// The outputs that are on, and the inputs that permit a pulse, until the next one; bit
/// 0: number 1.
struct AccessoryCommand {
  std::uint8_t on = 0;       ///< outputs; none is switched on while an interlock is open
  std::uint8_t watched = 0;  ///< inputs that have to be as in `levels`
  std::uint8_t levels = 0;   ///< only bits of `watched`
};
inline constexpr std::uint8_t kMaxAccessories = 8;

/// Bits of outputs and inputs that the controller does not have are 0.
struct AccessoryState {
  std::uint8_t output_count = 0, input_count = 0;  ///< 0..kMaxAccessories
  std::uint8_t on = 0;                             ///< outputs
  std::uint8_t levels = 0;                         ///< inputs that are on

  bool operator==(const AccessoryState&) const = default;
};

/// Decides ticks first_tick .. first_tick + fire.size() - 1. Ticks already decided or
/// passed are reported as late when they were to fire, and ignored otherwise.
struct ArmWindow {
  std::uint64_t first_tick = 0;
  bool gated = true;
  std::vector<bool> fire;  ///< at most kMaxArmTicks, one a tick
  bool at_place = false;   ///< only where `gated` is set and the identity offers it
  /// Of each pulse, within the identity's range: else the outcome is kEnergyOutside. 0 of
  /// a window that fires none.
  double pulse_energy_mj = 0;
  /// Of a laser that dwells at a point: the pulses that make it, at most
  /// kMaxPulsesPerPoint. 0: those that it makes by itself, of all others one.
  std::uint16_t pulses_per_point = 0;
};
inline constexpr std::size_t kMaxArmTicks = 4096;
inline constexpr double kMaxPulseEnergy_mj = 1e4;
inline constexpr std::uint16_t kMaxPulsesPerPoint = 10'000;

struct LaserIdentity {
  std::uint32_t power_up =
      0;  ///< random number drawn at power-up: another number is another clock
  bool lockstep = false;  ///< ticks pass only as far as they are decided
  std::uint8_t channels = 1;
  std::vector<double> rates_hz;    ///< at most 32
  std::string model;               ///< at most 64 bytes
  std::string serial_number = {};  ///< printable ASCII, at most 64; empty: it has none
  bool fires_at_place = false;     ///< takes windows `at_place`
  /// What the pulse energy can be set to, before a splitter; equal: it has one alone.
  double min_energy_mj = 0, max_energy_mj = 0;
  /// It locks the door by a magnet from before a shutter opens until all are closed, and
  /// fires no pulse while the lock does not hold.
  bool locks_door = false;
};

enum InterlockBits : std::uint8_t {
  kKeyOn = 1 << 0,
  kDoorClosed = 1 << 1,
  kStopReleased = 1 << 2,
  kLampOn = 1 << 3,
  kLampWarm = 1 << 4,
  kSafeState = 1 << 5,   ///< shutters closed by the controller itself
  kNoLampSync = 1 << 6,  ///< the laser's lamp sync is too short to be counted
  kDoorLocked = 1 << 7,  ///< the magnet holds the door; where the identity offers it
};

struct LaserStatus {
  std::uint64_t tick = 0;        ///< the newest lamp sync
  std::uint64_t machine_us = 0;  ///< controller's clock at that tick
  double rate_hz = 0;
  double warm_ratio = 0;           ///< 0..1
  std::uint8_t interlocks = 0;     ///< InterlockBits
  std::uint8_t shutters_open = 0;  ///< where they came to rest last
  /// Ticks that fired since power-up, however many pulses each of them made.
  std::uint64_t pulse_count = 0;
  std::uint64_t last_fired_tick = 0;  ///< 0: none
  std::uint64_t decided_through = 0;  ///< highest decided tick
  /// kDisarm frames taken in this session. A status that counts the newest one shows for
  /// certain which of the armed ticks never fired.
  std::uint32_t disarms_taken = 0;
  /// How often key, door, the stop button or a watched input let go since power-up: a
  /// person may have reached into the machine while no host listened, or between two
  /// statuses.
  std::uint32_t openings = 0;

  bool operator==(const LaserStatus&) const = default;
};
// The pulse reports of every tick up to and with LaserStatus::tick are sent before it.

enum class TickOutcome : std::uint8_t {
  kNotArmed = 0,
  kFiredSeen = 1,    ///< the photosensor of every open channel saw a crack
  kFiredUnseen = 2,  ///< that of an open channel saw none, or there is none
  kNotInPosition = 3,
  kInterlocked = 4,
  kLampNotReady = 5,
  kShutterClosed = 6,
  kTooLate = 7,
  kNoLongerKnown = 8,   ///< only in a PastReport
  kTriggerOutside = 9,  ///< too late or too short for the laser: no pulse
  kEnergyOutside = 10,  ///< the laser cannot make the commanded energy: no pulse
};
constexpr bool HasFired(TickOutcome outcome) {
  return outcome == TickOutcome::kFiredSeen || outcome == TickOutcome::kFiredUnseen;
}

/// Every decided tick is reported once, in order, without gap; a late one in a report
/// of its own with kTooLate.
struct PulseReport {
  std::uint64_t first_tick = 0;
  std::vector<TickOutcome> outcome;  ///< at most kMaxReportTicks, one a tick
  /// One a tick, bit 0..3: channels 1..4 that were open and whose photosensor saw none.
  /// Empty, or 0 with kFiredUnseen: not known.
  std::vector<std::uint8_t> missed = {};
  /// One a tick, of the pulses that fired, before a splitter. Empty, or 0: not
  /// measured.
  std::vector<float> measured_mj = {};
};
inline constexpr std::size_t kMaxReportTicks = 200;

/// What became of ticks that have passed, whichever host and session decided them.
struct PastRequest {
  std::uint64_t first_tick = 0;
  std::uint16_t count = 1;  ///< 1..kMaxPastTicks
};
inline constexpr std::size_t kMaxPastTicks = 512;

/// A tick that was not decided, or has not passed, is kNotArmed. A tick that was to fire
/// and had not passed can still fire: ask after a Disarm that a status counts.
struct PastReport {
  std::uint64_t first_tick = 0;
  std::vector<TickOutcome> outcome;       ///< at most kMaxPastTicks, one a tick
  std::vector<std::uint8_t> missed = {};  ///< as in PulseReport
};
/// A controller remembers at least this many ticks up to the newest, since its power-up.
inline constexpr std::size_t kRememberedTicks = 65536;

}  // namespace intaglio::link
