#pragma once

// A line that is opened again when it was lost: host's side of both lines.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "services/platform/link/endpoint.h"
#include "services/platform/link/reliable_link.h"

namespace intaglio::link {

/// Owns the link to one device over whatever number of openings of its line.
/// Not thread-safe; nothing blocks.
class LineSession {
 public:
  LineSession(StreamOpener open, SteadyClock clock);

  /// Moves bytes and hands frames over; reopens a lost line twice a second.
  void Poll(const ReliableLink::Handler& handler);
  bool CanSend() const { return link_ && link_->CanSend(); }
  Status Send(std::uint8_t type, std::span<const std::byte> payload = {});
  bool up() const { return link_ && link_->up(); }
  /// Grows with every new session with the device, over all openings.
  std::uint32_t sessions() const { return sessions_; }
  int fd() const { return link_ ? link_->fd() : -1; }
  /// A newer host has the device: this session is over for good, and sends nothing more.
  bool fenced() const { return epoch_->fenced; }
  /// Why the line is down; empty while it is up.
  const std::string& message() const { return message_; }

 private:
  void TryOpen();
  void KeepDownMessage();

  StreamOpener open_;
  SteadyClock clock_;
  std::shared_ptr<LineEpoch> epoch_ = std::make_shared<LineEpoch>();
  std::unique_ptr<ReliableLink> link_;
  std::uint32_t link_session_ = 0;
  std::uint32_t sessions_ = 0;
  std::chrono::nanoseconds next_open_{0};
  std::optional<std::chrono::nanoseconds> connected_at_ = {};
  std::string message_ = "the line is not open yet";
};

}  // namespace intaglio::link
