#pragma once

// The two protocols of a machine on one line: a controller that moves the stage and
// switches the laser. Their frames differ by type (motion_protocol.h, laser_protocol.h);
// session, window and epoch are those of the line. Host's side. Not thread-safe.

#include <array>
#include <deque>
#include <memory>
#include <string>

#include "services/platform/link/line_session.h"

namespace intaglio::link {

/// What a driver knows of its line: all of it, or the frames of one protocol on it. Each
/// port may be polled alone; what comes for the other one waits, at most kMaxWaiting
/// frames of it, the newest.
class FramePort {
 public:
  static constexpr std::size_t kMaxWaiting = 4096;

  /// The only port of a line of its own.
  FramePort(StreamOpener open, SteadyClock clock);
  /// Of one line: its motion frames, and all others.
  static std::array<FramePort, 2> Divide(StreamOpener open, SteadyClock clock);

  // As LineSession.
  void Poll(const ReliableLink::Handler& handler);
  bool CanSend() const;
  Status Send(std::uint8_t type, std::span<const std::byte> payload = {});
  bool up() const;
  std::uint32_t sessions() const;
  int fd() const;
  bool fenced() const;
  const std::string& message() const;

 private:
  struct Line;
  FramePort(std::shared_ptr<Line> line, std::size_t number);
  std::shared_ptr<Line> line_;
  std::size_t number_ = 0;
};

}  // namespace intaglio::link
