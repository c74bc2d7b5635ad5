#pragma once

// Which ticks fire, and what came of them: the part of the LinuxCNC driver that a laser
// controller of its own would have. Tick numbers since HAL's start.

#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <vector>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::drivers {

class LaserTicks {
 public:
  struct Decision {
    bool decided = false, fire = false, gated = false;
    bool interlocked = false;  ///< an interlock opened since: it fires nothing
  };

  /// Of another session or power-up: what was decided is void; `fired` is all that fired.
  void Begin(const std::vector<std::uint32_t>& fired);
  /// Ticks that are decided already, or whose rows are sent (up to `sent_through`), are
  /// too late.
  void Arm(const link::ArmWindow& window, std::uint64_t sent_through);
  /// The decision for a tick whose rows are sent now; in order.
  Decision TakeDecision(std::uint64_t tick);
  /// Forgets what is decided and not sent.
  void Disarm(std::uint64_t sent_through);
  /// An interlock is open: what is decided and not sent will not fire.
  void Interlock();
  /// Of a decided tick that has passed; in order.
  void Report(std::uint64_t tick, link::TickOutcome outcome);
  void RequestPast(std::uint64_t first_tick, std::uint16_t count);
  /// `newest`: the newest tick that has passed.
  void Deliver(std::uint64_t newest, const LaserController::ReportSink& sink,
               const LaserController::PastSink& past);

  std::uint64_t decided_through() const { return decided_through_; }
  std::uint64_t last_fired() const { return fired_.empty() ? 0 : *fired_.rbegin(); }

 private:
  link::PastReport PastOf(const link::PastRequest& request, std::uint64_t newest) const;

  std::map<std::uint64_t, Decision> decided_;
  std::uint64_t decided_through_ = 0;
  std::set<std::uint64_t> fired_;  // the newest kRememberedTicks ticks of them, at least
  std::deque<link::PulseReport> reports_;
  std::vector<link::PastRequest> requests_;
};

}  // namespace intaglio::drivers
