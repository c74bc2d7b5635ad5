#pragma once

// A laser controller at the far end of a line in memory, and the glass under it: an
// implementation of services/platform/link/laser_protocol.h of its own, one map entry a
// tick, with every fault at the test's hand.

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "services/platform/link/laser_protocol.h"
#include "services/platform/link/reliable_link.h"

namespace intaglio::synchronizer {

/// One pulse that left the laser.
struct Crack {
  std::uint32_t power_up = 0;
  std::uint64_t tick = 0;
  Vec3 at_mm = Vec3::Zero();
  bool seen = true;
  std::uint8_t channels = 0;  ///< whose shutters were open
  double energy_mj = 0;       ///< as commanded
};

class FakeLaser {
 public:
  static constexpr double kRateHz = 200;
  static constexpr double kWarmUpS = 0.1;

  FakeLaser(link::SteadyClock clock, bool lockstep)
      : lockstep_(lockstep), clock_(std::move(clock)) {}

  void Plug(std::unique_ptr<link::ByteStream> end);
  /// Another clock and other counters; lamp and shutters are off. The line stays in.
  void PowerCycle(std::unique_ptr<link::ByteStream> end);

  /// Bytes, frames, the safe state; no tick passes.
  void Poll();
  bool MayPassTick() const { return !lockstep_ || tick_ < decided_through_; }
  /// One lamp sync, with the stage at this place.
  void AdvanceTick(bool in_position, const Vec3& at_mm);

  std::uint64_t tick() const { return tick_; }
  bool lockstep() const { return lockstep_; }
  std::uint8_t shutters() const { return shutters_; }
  bool lamp_on() const { return lamp_on_; }
  std::uint8_t outputs() const { return commanded_.on; }
  const std::vector<Crack>& cracks() const { return cracks_; }
  /// Monotonic time of the newest window that wanted a pulse; 0: none came.
  std::chrono::nanoseconds newest_arm_at() const { return newest_arm_at_; }
  std::chrono::nanoseconds newest_pulse_at() const { return newest_pulse_at_; }
  int lamp_switched_on_count() const { return lamp_switched_on_count_; }
  /// How often shutters were asked to open, also for an instant.
  int shutters_asked_count() const { return shutters_asked_count_; }

  void PressStop(bool pressed);
  void EnterSafeState();

  /// What it reports at the next handshakes; another one: the line leads elsewhere.
  std::string serial_number = "A-03";
  std::vector<link::LaserFrame> received;  ///< all that came, in order

  bool key_on = true, door_closed = true;
  bool locks_door = false;   ///< reported at the next handshakes
  bool lock_broken = false;  ///< it does not hold
  /// For other uses, reported at the next handshakes; bit 0: number 1.
  std::uint8_t output_count = 0, input_count = 0;
  std::uint8_t input_levels = 0;  ///< inputs that are on
  std::uint32_t openings =
      0;                   ///< of these and the stop; a test adds what no status shows
  bool lamp_dead = false;  ///< does not burn, whatever is commanded
  bool shutter_stuck = false;   ///< closed, whatever is commanded
  std::uint8_t stuck_open = 0;  ///< shutters that are open, whatever is commanded
  std::chrono::nanoseconds shutter_travel{0};     ///< from the command to the movement
  bool blind = false;                             ///< the photosensor sees no crack
  std::uint8_t missed_channels = 0;               ///< reported with a pulse that none saw
  float measured_mj = 0;                          ///< reported with every pulse
  double min_energy_mj = 0, max_energy_mj = 1e4;  ///< reported at the next handshakes
  bool refuses_energy = false;                    ///< and makes no pulse, all the same
  bool short_sync = false;                        ///< the lamp sync is not counted
  bool trigger_late = false;                      ///< the Q-switch takes no trigger
  bool mute = false;     ///< keeps the line alive and reports nothing
  bool waits = false;    ///< for a silent host, as a machine whose time is simulated
  bool forgets = false;  ///< nothing that was asked about the past is known
  /// Called with each tick that is about to be armed, before it is.
  std::function<void(std::uint64_t tick)> on_arm;

 private:
  void Receive(link::LaserFrame type, std::span<const std::byte> payload);
  void Decide(const link::ArmWindow& window);
  void Disarm();
  void Send(link::LaserFrame type, link::Bytes payload);
  void SendReports();
  void SendStatus();
  void SendAccessories();
  bool inputs_hold() const {
    return ((input_levels ^ commanded_.levels) & commanded_.watched) == 0;
  }
  link::PastReport Past(const link::PastRequest& asked) const;
  link::LaserStatus Status() const;
  bool warm() const { return burns() && lamp_s_ >= kWarmUpS; }
  bool burns() const { return lamp_on_ && !lamp_dead; }
  std::uint8_t OpenNow() const {
    return shutter_stuck ? std::uint8_t{0}
                         : static_cast<std::uint8_t>(shutters_ | stuck_open);
  }
  void AskShutters(std::uint8_t open_mask);
  void MoveShutters();
  struct Decision {
    bool fire = false;
    bool gated = true;
    double energy_mj = 0;
  };
  link::TickOutcome OutcomeAt(const Decision& decision, bool in_position) const;

  bool lockstep_;
  link::SteadyClock clock_;
  std::unique_ptr<link::ReliableLink> line_;
  std::shared_ptr<link::LineEpoch> epoch_ = std::make_shared<link::LineEpoch>();
  std::uint32_t session_ = 0;
  std::uint32_t power_up_ = 1;
  std::uint64_t tick_ = 0;
  bool was_shut_ = true;
  bool lamp_on_ = false;
  double lamp_s_ = 0;
  std::uint8_t shutters_ = 0, shutters_asked_ = 0;
  int shutters_asked_count_ = 0;
  std::chrono::nanoseconds shutters_move_at_{-1};
  bool stop_pressed_ = false, stop_latched_ = false, safe_ = false;
  std::map<std::uint64_t, Decision> decided_;  // ticks to come
  std::uint64_t decided_through_ = 0;
  std::uint64_t pulse_count_ = 0, last_fired_tick_ = 0;
  std::uint32_t disarms_taken_ = 0;
  std::vector<std::pair<std::uint64_t, link::TickOutcome>> outcomes_;
  std::map<std::uint64_t, link::TickOutcome> past_;  // of decided ticks since power-up
  std::deque<std::pair<link::LaserFrame, link::Bytes>> waiting_;
  bool status_asked_ = false;
  std::uint32_t sent_state_ = 0;
  link::AccessoryCommand commanded_;
  link::AccessoryState sent_accessories_;
  std::chrono::nanoseconds next_status_{0}, newest_arm_at_{0}, newest_pulse_at_{0};
  int lamp_switched_on_count_ = 0;
  std::vector<Crack> cracks_;
};

}  // namespace intaglio::synchronizer
