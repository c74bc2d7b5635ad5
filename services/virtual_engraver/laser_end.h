#pragma once

// The laser controller's end of its line: what the newest host commands reaches the
// laser, and the host receives its identity, the outcomes of ticks, and its status every
// 20 ms, on every change of an interlock or shutter, and when it asks. A host that falls
// silent while something could fire, or an output is on, puts the laser into its safe
// state.
//
// The virtual engraver, the stand-in of a replayed cell and the reference controller
// serve their lines with it. Not thread-safe; nothing blocks.

#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>

#include "services/virtual_engraver/laser.h"
#include "services/virtual_engraver/lines/device_line.h"

namespace intaglio::virtual_engraver {

/// Between two statuses that nobody asked for, of laser and stage: of a machine that
/// works and of one that rests.
inline constexpr std::chrono::milliseconds kStatusPeriod{20}, kRestingStatusPeriod{40};

class LaserEnd {
 public:
  /// `laser` outlives this.
  explicit LaserEnd(Laser& laser) : laser_(laser) {}
  LaserEnd(const LaserEnd&) = delete;
  LaserEnd& operator=(const LaserEnd&) = delete;

  /// As DeviceLine::Plug.
  void Plug(std::unique_ptr<link::ByteStream> end, const link::SteadyClock& clock,
            bool waits = false) {
    line_.Plug(std::move(end), clock, waits);
  }
  /// Obeys what has come; then `also` gets each frame, too, where it is given. True when
  /// a new session has begun: its identity waits to be sent.
  bool Poll(const link::ReliableLink::Handler& also = {});
  /// The safe state, where the host is silent and something could fire or is on.
  void KeepSafe() {
    if (line_.silent() && laser_.is_live()) laser_.EnterSafeState();
  }
  /// Outcomes go before the status, which speaks of ticks whose outcomes are known;
  /// before them the inputs that may have decided them.
  void SendOutcomes();
  /// When it is due, or `at_once`; due again after `period`.
  void SendStatus(std::chrono::nanoseconds now, bool at_once,
                  std::chrono::nanoseconds period);

  DeviceLine& line() { return line_; }
  const DeviceLine& line() const { return line_; }

 private:
  void Obey(link::LaserFrame type, std::span<const std::byte> payload);
  void SendAccessories();

  Laser& laser_;
  DeviceLine line_;
  std::uint32_t sent_interlocks_ = 0;
  link::AccessoryState sent_accessories_;  // in this session
};

}  // namespace intaglio::virtual_engraver
