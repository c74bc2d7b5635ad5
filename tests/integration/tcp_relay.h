#pragma once

// A TCP connection that passes through the test: it hands bytes on, or holds them back
// with both ends open, as a network does whose cable is out for a while.

#include <atomic>
#include <string>
#include <thread>

namespace intaglio::testing {

class TcpRelay {
 public:
  /// To "tcp:127.0.0.1:PORT"; each connection that comes makes one there. Throws
  /// std::runtime_error where it cannot be.
  explicit TcpRelay(const std::string& device);
  ~TcpRelay();
  TcpRelay(const TcpRelay&) = delete;
  TcpRelay& operator=(const TcpRelay&) = delete;

  /// What a host has to open.
  std::string device() const;
  /// True: nothing passes, and nothing is lost; it comes when this ends.
  void Hold(bool holds) { holds_ = holds; }

 private:
  void Run(const std::stop_token& stop);

  std::uint16_t to_port_ = 0, own_port_ = 0;
  int listener_ = -1;
  std::atomic<bool> holds_ = false;
  std::jthread thread_;
};

}  // namespace intaglio::testing
