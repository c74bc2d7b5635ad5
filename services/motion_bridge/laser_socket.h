#pragma once

// The socket at which a bridge serves the laser of its motion controller, when the
// machine profile's laser_line.protocol is "motion-output" (drivers::LaserOutput).
//
// One host at a time: a second one is turned away while the first is connected, so that
// nobody takes a machine in mid-job. Without a laser there is no host.

#include <array>
#include <memory>
#include <string>

#include "services/drivers/laser_output.h"
#include "services/platform/link/steady_clock.h"
#include "services/platform/link/unix_stream.h"

namespace intaglio::motion_bridge {

class LaserSocket {
 public:
  /// `device`: "unix:/PATH".
  LaserSocket(drivers::LaserController& laser, std::string device,
              link::SteadyClock clock = link::MonotonicClock());

  void Turn();
  /// An orderly end: no host any more, the laser closed and disarmed; then Turn until
  /// closed().
  void Close();
  bool closed() const { return output_.closed(); }
  /// For poll(2): the host's and the listener's; -1 when there is none.
  std::array<int, 2> descriptors() const;
  /// Why nobody can open it; empty: it is served, or the line of both is down.
  const std::string& message() const {
    return message_.empty() ? laser_.refusal() : message_;
  }

 private:
  void Listen();
  void AcceptHosts();

  drivers::LaserController& laser_;
  drivers::LaserOutput output_;
  std::string device_;
  link::SteadyClock clock_;
  std::unique_ptr<link::UnixListener> listener_;
  std::chrono::nanoseconds next_listen_{0};
  bool closing_ = false;
  std::string message_;
};

}  // namespace intaglio::motion_bridge
