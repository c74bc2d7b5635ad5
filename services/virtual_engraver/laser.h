#pragma once

// The laser and its controller: lamp, warm-up, tick counter, decided ticks, interlocks,
// shutters, Q-switch. What it may fire at a tick:
//
//   armed -> [gated: in position; at a place: compare output] -> key, door, stop, watched
//   inputs -> no safe state -> lamp warm
//         -> a shutter is open, and none moves -> [the door is locked] -> the Q-switch
//         takes the trigger
//         -> the commanded energy is within its range -> pulse
//
// The first link that does not hold is the outcome. Nothing passes at all while the lamp
// sync is too short for the controller to count. Not thread-safe; time is AdvanceTick.

#include <array>
#include <cstdint>
#include <deque>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "services/platform/link/laser_protocol.h"
#include "services/virtual_engraver/accessories.h"
#include "services/virtual_engraver/laser_signals.h"

namespace intaglio::virtual_engraver {

struct LaserOptions {
  std::vector<double> rates_hz = {100};
  double warm_up_s = 30;      ///< machine time from lamp on
  std::uint8_t channels = 1;  ///< 1..4
  bool lockstep = false;
  std::uint32_t power_up = 1;                     ///< random number of this power-up
  std::string serial_number = "virtual-laser-1";  ///< empty: it has none
  std::string model = "Intaglio virtual engraver";
  bool fires_at_place = true;   ///< it has the stage's compare output
  bool measures_energy = true;  ///< it has detectors for the energy of a pulse
  LaserSignals signals = {};
  /// What the energy of a pulse can be set to, before a splitter.
  double min_energy_mj = 0.001, max_energy_mj = 30;
  /// All pulses are off by the one; each by up to the other, uniform, with an
  /// rms of 1 / sqrt(3) of it (Trochimczuk 2008, annex D, table 10: 2 % rms, so 0.0346).
  double energy_error_ratio = 0, energy_spread_ratio = 0.02;
  unsigned seed = 0;        ///< of the spread
  bool locks_door = false;  ///< a magnet holds the door while a shutter is open
  /// Outputs and inputs for other uses, at most link::kMaxAccessories of each; the
  /// inputs by their levels at power-up.
  std::size_t output_count = 0;
  std::vector<bool> inputs = {};
};

class Laser {
 public:
  explicit Laser(LaserOptions options);

  // From the line.
  /// Obeys what a frame commands; false: it commands nothing (a question, or a frame of
  /// another version).
  bool Obey(link::LaserFrame type, std::span<const std::byte> payload);
  void SetLamp(const link::LampCommand& command);
  void SetShutters(std::uint8_t open_mask);
  void SetTiming(const link::PulseTiming& timing) { timing_ = timing; }
  const link::PulseTiming& timing() const { return timing_; }
  /// Outputs and inputs for other uses.
  void Command(const link::AccessoryCommand& command);
  const link::AccessoryState& accessories() const { return accessories_.state(); }
  void Decide(const link::ArmWindow& window);
  void Disarm();
  void Stop() {
    stop_latched_ = true;
    EnterSafeState();
  }
  void Reset();
  /// A new host: it knows nothing of what was decided, and counts its Disarms anew.
  void NewSession();

  // From the machine.
  void SetKey(bool on) { Set(key_on_, on); }
  void SetDoor(bool closed) { Set(door_closed_, closed); }
  /// The magnet of the door's lock does not hold any more; false: it does again.
  void BreakLock(bool broken) { lock_broken_ = broken; }
  /// The magnet holds the closed door: from before a shutter opens until all have closed.
  bool door_locked() const;
  void SetStopButton(bool pressed);
  /// `input`: from 0, below accessories().input_count.
  void SetInput(std::size_t input, bool on) {
    accessories_.SetInput(input, on);
    CheckInputs();
  }
  /// The lamp has gone cold: it warms up from the beginning, if it burns.
  void CoolLamp() { lamp_s_ = 0; }
  /// Shutters closed, nothing decided, until Reset.
  void EnterSafeState();

  /// The lamp sync is long enough for the controller: else no tick passes.
  bool CountsSync() const {
    return options_.signals.sync_width_us > timing_.min_sync_width_us;
  }
  /// The next tick is decided (fire or not).
  bool NextIsDecided() const { return tick_ + 1 <= decided_through_; }
  /// The next tick is armed to fire at a place: then AdvanceTick is given the stage's
  /// compare output instead of the in-position output.
  bool NextFiresAtPlace() const;
  /// Something could still fire without another command of the host, or an output is on.
  bool is_live() const {
    return shutters_ != 0 || !windows_.empty() || accessories_.state().on != 0;
  }
  /// One lamp sync later, which comes `late_s` after its time. Returns the mask of
  /// channels that fire; 0: no pulse.
  std::uint8_t AdvanceTick(bool in_position, double late_s = 0);
  /// The pulse that AdvanceTick returned does not come: its controller was too late to
  /// trigger it.
  void Withhold();
  /// Energy of the pulse that AdvanceTick returned, before a splitter; detectors measure
  /// it exactly.
  double pulse_energy_mj() const { return pulse_energy_mj_; }
  /// Since power-up; a point of which it makes several pulses has them all.
  std::uint64_t made_pulse_count() const { return made_pulse_count_; }
  /// The photosensors of these channels saw no flash of the pulse that AdvanceTick
  /// returned.
  void Missed(std::uint8_t channels);
  /// There are no photosensors: nobody knows what came of it.
  void Unseen();
  /// Whether a photosensor would count a flash at this height, glass frame.
  bool CountsFlashAt(double height_mm) const {
    return height_mm >= timing_.min_flash_height_mm &&
           height_mm <= timing_.max_flash_height_mm;
  }

  double rate_hz() const { return rate_hz_; }
  bool lamp_is_on() const { return lamp_on_; }
  std::uint64_t tick() const { return tick_; }
  std::uint8_t shutters() const { return shutters_; }
  link::LaserStatus Report() const;
  link::LaserIdentity Identity() const;
  /// Outcomes since the last call, late ones in reports of their own.
  std::vector<link::PulseReport> TakeReports();
  /// What came of any ticks since power-up, whichever session they were decided in.
  link::PastReport Past(const link::PastRequest& asked) const;

 private:
  /// One of the interlocks, counted when it lets go.
  void Set(bool& holds, bool now);
  void CheckInputs() { Set(inputs_hold_, accessories_.hold()); }
  bool interlocked() const;
  link::TickOutcome OutcomeAt(bool armed, const link::ArmWindow& window,
                              bool in_position) const;
  void MoveShutters(std::uint8_t open_mask);
  bool ShuttersMove(double time_s) const {
    return machine_s_ < shutters_moved_s_ + time_s;
  }
  void Note(std::uint64_t tick, link::TickOutcome outcome);
  void Discharge(double energy_mj);

  LaserOptions options_;
  double rate_hz_;
  double next_rate_hz_;
  std::uint64_t tick_ = 0;
  double machine_s_ = 0;
  bool lamp_on_ = false;
  double lamp_s_ = 0;
  std::uint8_t shutters_ = 0;         // as commanded
  std::uint8_t shutters_before_ = 0;  // as they were before they began to move
  double shutters_moved_s_ = -1e9;    // when they began, in machine time
  link::PulseTiming timing_ = {};
  Accessories accessories_;
  bool key_on_ = true, door_closed_ = true, stop_released_ = true, inputs_hold_ = true;
  bool stop_latched_ = false, safe_state_ = false, lock_broken_ = false;
  std::uint64_t decided_through_ = 0;
  std::deque<link::ArmWindow> windows_;
  std::uint64_t pulse_count_ = 0, made_pulse_count_ = 0, last_fired_tick_ = 0;
  std::uint64_t fired_before_tick_ = 0;  // the one before last_fired_tick_
  std::uint16_t pulses_of_point_ = 0;    // of the pulse that AdvanceTick returned
  double pulse_energy_mj_ = 0;
  std::uint8_t pulse_channels_ = 0;
  std::mt19937_64 random_;
  std::uint32_t disarms_taken_ = 0, openings_ = 0;
  std::vector<link::PulseReport> reports_;
  // Outcome of tick t at t modulo the size.
  std::array<link::TickOutcome, link::kRememberedTicks> past_{};
  std::array<std::uint8_t, link::kRememberedTicks> past_missed_{};
};

}  // namespace intaglio::virtual_engraver
