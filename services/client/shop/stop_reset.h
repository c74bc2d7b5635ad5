#pragma once

// The release of a machine's emergency stops by a person, who has seen which presses it
// reports: those are released, and one that came meanwhile is not. The stop that the
// machine's own controller keeps latched is taken back with them, if its button is
// released. Nothing moves or fires by it; a job goes on when it is armed or resumed.
//
//   kBegins --presses are seen--------------------> kReleases --none held--> kOwnStop
//      |                                              ^                         |
//      +--none, its own stop is latched--> kPresses --+    its own stop is released, or
//         (a press of this source)         it holds it     kOwnStopTime has passed
//                                                                               |
//                                                                             kOver
//
// A machine resets its own stop by the release of a press that it held, and by nothing
// else, so the last way down presses first: the machine is stopped already.

#include <chrono>
#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/client/shop/shop_stops.h"

namespace intaglio::client {

/// Sent by the constructor's process as a source of its own, until it ends: a machine
/// that is discovered late gets it, too.
class StopReset {
 public:
  using Clock = std::chrono::steady_clock;
  /// For the machine's own stop, once no press holds it.
  static constexpr std::chrono::milliseconds kOwnStopTime{1000};

  /// `program`: the beginning of the source's name. `seen`: presses of this machine.
  /// `reason`: for the log.
  StopReset(bus::Bus& bus, const std::string& program, const std::string& cell,
            HeldPresses seen, std::string reason)
      : seen_(std::move(seen)),
        reason_(std::move(reason)),
        source_(std::make_unique<StopSource>(bus, program, cell)) {}

  /// Again and again with what the machine reports, which it does, until is_over().
  Status Turn(const MachineStops& stops, Clock::time_point now);
  bool is_over() const { return phase_ == Phase::kOver; }
  /// The machine holds none of the presses any more.
  bool IsReleased(const MachineStops& stops) const;

 private:
  enum class Phase : std::uint8_t { kBegins, kPresses, kReleases, kOwnStop, kOver };

  Status Begin(const MachineStops& stops);
  Status Release();

  HeldPresses seen_;
  std::string reason_;
  std::unique_ptr<StopSource> source_;
  Phase phase_ = Phase::kBegins;
  Clock::time_point own_stop_ends_;
};

/// "intaglio-stop-bench-1234-17f (number 1)", as MachineStatus.stops_held has it.
std::string TextOf(const HeldPress& press);

/// Why the machine is still held after its reset, with what to do; empty: it is not.
std::string WhyStillHeld(const std::string& cell, const MachineStops& stops);

}  // namespace intaglio::client
