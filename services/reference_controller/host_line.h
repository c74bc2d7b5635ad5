#pragma once

// The controller's end of a line: a serial port, or a plug with the hosts that come to
// it. Not thread-safe.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "services/virtual_engraver/lines/machine_line.h"

namespace intaglio::reference_controller {

struct HostLineOptions {
  /// "serial:DEVICE", or as OpenMachineLine takes it.
  std::string device;
  std::uint32_t baud = 115200;  ///< of a serial port
  std::string name;             ///< for messages
};

class HostLine {
 public:
  static constexpr std::string_view kSerial = "serial:";

  /// `plug` gets the controller's end, now and after each host; `is_plugged`: no port of
  /// it was lost. kIo and kInvalidValue as the opening of the line has them.
  static Result<HostLine> Open(
      HostLineOptions options,
      std::function<void(std::unique_ptr<link::ByteStream>)> plug,
      std::function<bool()> is_plugged);

  /// What a host has to open.
  std::string device() const;
  /// After a host has gone, and after a port was lost.
  void Renew();
  /// Ends sooner when something comes.
  void WaitFor(std::chrono::nanoseconds time) const;

 private:
  HostLine() = default;
  Status OpenPort();

  HostLineOptions options_;
  std::function<void(std::unique_ptr<link::ByteStream>)> plug_in_;
  std::function<bool()> is_plugged_;
  std::string port_;
  std::unique_ptr<virtual_engraver::MachineLine> plug_;
  int fd_ = -1;
  std::chrono::steady_clock::time_point next_open_ = {};
};

}  // namespace intaglio::reference_controller
