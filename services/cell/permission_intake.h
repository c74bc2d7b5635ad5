#pragma once

// What a cell receives of the operator's permission and of emergency stops: the one
// receiver of every kind of machine. Used from one thread.

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "services/cell/grant_inputs.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/safety/stop_latch.h"

namespace intaglio::cell {

class PermissionIntake {
 public:
  PermissionIntake(bus::Bus& bus, const std::string& cell);

  /// Once a turn, before the inputs are asked for.
  void Receive(std::chrono::nanoseconds now);
  /// Behind Receive: the presses that another listener of this machine holds; empty:
  /// none.
  void ReceiveHeld(std::string_view listener,
                   std::span<const intaglio_StopPress> presses);
  /// As far as the permission is that of this job; `job_uid` empty: of none.
  GrantInputs InputsFor(const std::string& job_uid, std::uint64_t epoch,
                        std::chrono::nanoseconds now) const;
  const host::StopLatch& stop() const { return stop_; }
  /// Held, or pressed in this turn, though it may be released by now.
  bool stopped() const { return stop_.pressed() || stop_came_; }

  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(permissions_);
    loop.Attach(stops_);
  }

 private:
  void NoteStop(std::string_view source, std::string_view reason);

  bus::Reader<intaglio_Permission> permissions_;
  bus::Reader<intaglio_EmergencyStop> stops_;
  host::StopLatch stop_;
  bool stop_came_ = false;
  std::chrono::nanoseconds received_at_{-1};
  bool granted_ = false, fire_uncertain_ = false;
  std::uint64_t epoch_ = 0;
  Grant grant_;
  std::uint32_t first_point_ = 0, speed_percent_ = 100;
  std::string job_uid_;
};

}  // namespace intaglio::cell
