#pragma once

// A laser controller with real outputs. What may fire, the interlocks, the safe state and
// the protocol are those of the virtual engraver (laser.h, laser_end.h), and no second
// ones; this makes its ticks of a real lamp, and real edges of its pulses.
//
//   a tick:  lamp trigger -> lamp sync -> key, door, stop, inputs, in-position are read
//            -> Laser::AdvanceTick decides -> Q-switch on, off -> photosensors -> outcome
//
// A tick begins with the laser's lamp sync, or, where none is wired, with the lamp
// trigger. Without a lamp trigger the laser flashes by itself, and its lamp sync is
// waited for around the time at which it is due. A tick whose trigger would be later than
// the laser takes it is withheld: its outcome is kTriggerOutside.
//
// A stage on the same board has a clock of its own, on which the host has placed the
// ticks. When a tick is left out or late by a tenth of a period, all that was placed
// before is of another point. The host sees it within ten ticks, and on a line with a
// jitter of half a tick within the 100 ticks or the second that its stamps' newest
// quarter takes (motion_clock.h). None passes the gate before a run that begins
// StaleTicks() later.
//
// Outputs are off from before the line opens; when the board fails, a call of it is an
// error; and when this object is gone. While Turn is called, Output::kAlive changes at
// least every 20 ms. What a process that is killed leaves on its outputs is the kernel's:
// the hardware gate that kAlive holds open closes (docs/machines/els-03.md).
//
// Not thread-safe. Around a tick, Turn waits up to kSpin, and for trigger and flash.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "services/reference_controller/pins.h"
#include "services/reference_controller/tick_ring.h"
#include "services/virtual_engraver/laser_end.h"

namespace intaglio::reference_controller {

/// The clock of the edges, and a wait on it that is as exact as the system allows.
struct ControllerTime {
  link::SteadyClock clock;
  std::function<void(std::chrono::nanoseconds)> wait_until;
};

/// What a stage with a clock of its own knows.
struct StageWitness {
  /// So long it is in position, on the clock of the edges: one that hangs leaves its
  /// output on.
  std::chrono::nanoseconds in_position_until{0};
  /// Runs that have begun.
  std::uint32_t runs = 0;
};

struct ControllerOptions {
  virtual_engraver::LaserOptions laser;
  /// How long after the trigger a flash is seen, > 0.
  std::chrono::nanoseconds sensor_window{300'000};
  /// Each tick at its lamp sync, with the rate of the lamp; short, for the trigger waits
  /// behind it. Empty: nobody is notified.
  std::function<void(const TickNotice&)> on_tick = {};
  /// The stage of the same board; no tick passes the gate without it, whatever the input
  /// shows. Empty: the input alone counts.
  std::function<StageWitness()> stage = {};
};

class Controller {
 public:
  /// The longest between two calls of Turn.
  static constexpr std::chrono::nanoseconds kIdle{5'000'000};
  /// The processor waits so long for a tick, and does nothing else.
  static constexpr std::chrono::nanoseconds kSpin{500'000};

  /// `pins` outlive this.
  Controller(const ControllerOptions& options, Pins& pins, ControllerTime time);
  ~Controller() { MakeSafe(); }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  /// The controller's end of the line; null unplugs it.
  void Plug(std::unique_ptr<link::ByteStream> end);
  /// The line is there: no port of it was lost.
  bool is_plugged() const { return end_.line().is_plugged(); }
  /// Line, interlocks, outputs, and the tick that is due. Returns how long nothing is
  /// due. kIo when the board fails: then everything is off.
  Result<std::chrono::nanoseconds> Turn();
  /// The safe state of the laser, and every output off, what fires first.
  void MakeSafe();

  virtual_engraver::Laser& laser() { return laser_; }

 private:
  using Time = std::chrono::nanoseconds;

  Result<Time> TryTurn();
  Result<bool> ReadInputs();
  Status WriteOutputs();
  Time Period() const;
  Result<std::optional<Time>> AwaitTick();
  Result<std::optional<Time>> AwaitOwnTick();
  Result<std::optional<Time>> AwaitSync(Time until);
  void LoseTime();
  std::uint64_t StaleTicks() const;
  bool StageAgrees(Time sync);
  Status PassTick(Time sync);
  Status Trigger(std::uint8_t channels, Time sync);
  Result<bool> HadEdge(Input input);
  Result<std::uint8_t> Flashes();

  ControllerOptions options_;
  Pins& pins_;
  ControllerTime time_;
  virtual_engraver::Laser laser_;
  virtual_engraver::LaserEnd end_{laser_};
  Time next_tick_at_;
  std::optional<Time> last_sync_;
  std::optional<std::uint64_t> lost_time_at_;  // the tick before
  std::uint32_t run_ = 0;                      // of the stage, the newest
  std::uint64_t run_began_at_ = 0;             // its tick
  bool alive_ = false;
};

}  // namespace intaglio::reference_controller
