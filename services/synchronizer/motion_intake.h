#pragma once

// What a cell receives from its motion bridge: the newest state of the stage, and, of a
// controller with a clock of its own, what that clock showed at the lamp's ticks. Used
// from one thread.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/cell/permission_intake.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/platform/bus/bus.h"
#include "services/synchronizer/engraving/engraving_inputs.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/motion_clock.h"

namespace intaglio::synchronizer {

class MotionIntake {
 public:
  MotionIntake(bus::Bus& bus, const std::string& cell);

  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(states_);
    loop.Attach(positions_);
  }

  /// Once a turn, behind permission.Receive(): the bridge's presses of emergency stops go
  /// there. `laser` has the ticks that the clock's stamps are of.
  void Receive(PermissionIntake& permission, const drivers::LaserController& laser,
               std::chrono::nanoseconds now);
  /// `grant` with the stage beside it.
  EngravingInputs InputsWith(const GrantInputs& grant);
  /// As InputsWith, of the stage's state alone.
  const MotionView& view() const { return view_; }

 private:
  void ReceivePositions(const drivers::LaserController& laser);

  bus::Reader<intaglio_MotionState> states_;
  bus::Reader<intaglio_PositionReport> positions_;
  MotionView view_;
  MotionClock clock_;
  /// What the clock's stamps are of: it, the laser's power-up, and the lamp's rate.
  struct ClockPair {
    std::uint32_t motion = 0, laser = 0;
    double rate_hz = 0;
    bool operator==(const ClockPair&) const = default;
  };
  ClockPair clock_pair_;
  std::uint64_t clock_from_tick_ = 0;  ///< at this rate since then
  std::chrono::nanoseconds received_at_{-1};
};

}  // namespace intaglio::synchronizer
