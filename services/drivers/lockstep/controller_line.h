#pragma once

// What the lines to a controller that answers in text have in common: the device that is
// opened again and again, the bytes that wait for it, and why the line is down.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class ControllerLine {
 public:
  virtual ~ControllerLine() = default;

  /// Identified and answering.
  virtual bool up() const = 0;
  /// For poll(2); -1 when there is none.
  int fd() const { return stream_ ? stream_->fd() : -1; }
  /// Grows when the controller was switched off, or was reset by another than this host.
  std::uint32_t power_ups() const { return power_ups_; }
  std::uint64_t sessions() const { return sessions_; }
  /// Why it is down; empty while it is up.
  const std::string& message() const { return message_; }
  /// Why the controller is refused, and what to do; empty: it is not.
  const std::string& refusal() const { return refusal_; }

 protected:
  ControllerLine(link::StreamOpener open, link::SteadyClock clock);

  /// Every 500 ms, while there is no stream. True: it was opened now.
  bool OpenStream();
  /// Moves what waits to the stream.
  void Write();
  std::chrono::nanoseconds now() const { return clock_(); }

  std::unique_ptr<link::ByteStream> stream_;
  std::string out_;  ///< waits to be written
  std::uint32_t power_ups_ = 1;
  std::uint64_t sessions_ = 0;
  std::string message_ = "the line is not open yet", refusal_;

 private:
  link::StreamOpener open_;
  link::SteadyClock clock_;
  std::chrono::nanoseconds next_open_{0};
};

}  // namespace intaglio::drivers
