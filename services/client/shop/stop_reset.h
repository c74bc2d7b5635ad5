#pragma once

// The release of a machine's emergency stops by a person, who has seen which presses it
// reports: those are released, and one that came meanwhile is not. Nothing moves or fires
// by it; a job goes on when it is armed or resumed.

#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/client/shop/shop_stops.h"

namespace intaglio::client {

/// Sent by the constructor's process as a source of its own, until it ends: a machine
/// that is discovered late gets it, too.
class StopReset {
 public:
  /// `program`: the beginning of the source's name. `seen`: presses of this machine.
  StopReset(bus::Bus& bus, const std::string& program, const std::string& cell,
            HeldPresses seen)
      : seen_(std::move(seen)),
        source_(std::make_unique<StopSource>(bus, program, cell)) {}

  /// `reason`: for the log.
  Result<std::uint64_t> Send(const std::string& reason) {
    return source_->Release(seen_, reason);
  }
  /// The machine holds none of them any more.
  bool IsConfirmed(const MachineStops& stops) const;

 private:
  HeldPresses seen_;
  std::unique_ptr<StopSource> source_;
};

/// "intaglio-stop-bench-1234-17f (number 1)", as MachineStatus.stops_held has it.
std::string TextOf(const HeldPress& press);

/// Why the machine is still held after its reset, with what to do; empty: it is not.
std::string WhyStillHeld(const std::string& cell, const MachineStops& stops);

/// What follows a reset, behind which nothing holds the machine.
std::string AfterReset(const MachineStops& stops);

}  // namespace intaglio::client
