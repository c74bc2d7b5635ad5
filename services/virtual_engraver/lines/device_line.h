#pragma once

// The machine's side of one line: the link to the host of the moment, what waits to be
// sent to it, and its newest session.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>

#include "services/platform/link/message.h"
#include "services/platform/link/reliable_link.h"

namespace intaglio::virtual_engraver {

class DeviceLine {
 public:
  /// What the host has not received yet is bounded by it: a clock in lockstep stops.
  static constexpr std::size_t kMaxWaiting = 256;

  /// The machine's end of the line is plugged in; null unplugs it. What waited is
  /// dropped. `waits`: the machine's time stops for a silent host (lockstep).
  void Plug(std::unique_ptr<link::ByteStream> end, const link::SteadyClock& clock,
            bool waits = false);
  /// Passes what has come to `handler`. True when a new session has begun, for which
  /// nothing waits.
  bool Poll(const link::ReliableLink::Handler& handler);
  /// Nothing is heard of a host that was there.
  bool silent() const { return session_ != 0 && !is_up(); }
  bool is_up() const { return link_ != nullptr && link_->up(); }
  /// Its end is plugged in, and not lost.
  bool is_plugged() const { return link_ != nullptr; }
  bool is_full() const { return waiting_.size() >= kMaxWaiting; }
  /// The next session is a new one, even if it has the same number.
  void ForgetSession() { session_ = 0; }

  template <typename Frame>
  void Send(Frame type, link::Bytes payload) {
    waiting_.emplace_back(static_cast<std::uint8_t>(type), std::move(payload));
  }
  /// Sends what waits, as far as the host takes it.
  void Flush();

  // When the host gets its next status: asked for, or after the period of the machine.
  void AskForStatus() { status_asked_ = true; }
  bool IsStatusDue(std::chrono::nanoseconds now) const {
    return status_asked_ || now >= next_status_;
  }
  std::chrono::nanoseconds next_status() const { return next_status_; }
  void SetNextStatus(std::chrono::nanoseconds at) {
    status_asked_ = false;
    next_status_ = at;
  }

 private:
  std::unique_ptr<link::ReliableLink> link_;
  std::shared_ptr<link::LineEpoch> epoch_ = std::make_shared<link::LineEpoch>();
  std::uint32_t session_ = 0;
  std::deque<std::pair<std::uint8_t, link::Bytes>> waiting_;
  std::chrono::nanoseconds next_status_{0};
  bool status_asked_ = false;
};

}  // namespace intaglio::virtual_engraver
