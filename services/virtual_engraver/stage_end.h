#pragma once

// The stage controller's end of its line: what the newest host commands reaches the
// stage, and the host receives its identity, positions, and its status after each period,
// on every fault, and when it asks. A host that falls silent while the stage moves stops
// it.
//
// The virtual engraver and the reference controller serve their lines with it. Not
// thread-safe; nothing blocks.

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "services/virtual_engraver/lines/device_line.h"
#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {

class StageEnd {
 public:
  /// `stage` outlives this. `before_abort`: the stage has to be moved up to the present
  /// before it brakes.
  explicit StageEnd(Stage& stage, std::function<void()> before_abort = {})
      : stage_(stage), before_abort_(std::move(before_abort)) {}
  StageEnd(const StageEnd&) = delete;
  StageEnd& operator=(const StageEnd&) = delete;

  /// As DeviceLine::Plug.
  void Plug(std::unique_ptr<link::ByteStream> end, const link::SteadyClock& clock,
            bool waits = false) {
    own_line_.Plug(std::move(end), clock, waits);
  }
  /// Its frames go over this line, which another one polls: it gives Obey the frames, and
  /// calls Greet for each new session. `line` outlives this.
  void ShareLine(DeviceLine& line) { shared_line_ = &line; }

  /// Obeys what has come on its own line.
  void Poll();
  void Obey(link::MotionFrame type, std::span<const std::byte> payload);
  /// Identity, speed, tolerance and clock, first in a session.
  void Greet();
  /// A stage that moves without a host is stopped.
  void KeepSafe();
  /// Positions go before the status.
  void SendPositions();
  /// When it is due, or `at_once`; due again after `period`.
  void SendStatus(std::chrono::nanoseconds now, bool at_once,
                  std::chrono::nanoseconds period);

  /// What carries its frames.
  DeviceLine& line() { return shared_line_ != nullptr ? *shared_line_ : own_line_; }
  /// Its own one; a line that it shares has another period of statuses.
  DeviceLine& own_line() { return own_line_; }
  const DeviceLine& own_line() const { return own_line_; }

 private:
  Stage& stage_;
  std::function<void()> before_abort_;
  DeviceLine own_line_;
  DeviceLine* shared_line_ = nullptr;
  link::StageFault sent_fault_ = link::StageFault::kNone;
};

}  // namespace intaglio::virtual_engraver
