#pragma once

// Which device a serial line has to lead to. Two cells on one computer have four cables
// that fit four sockets: without this check a synchronizer would fire the other cell's
// laser into the other cell's block. The serial number is what the device reports in its
// identity at every handshake; the expected one is written in the machine profile.

#include <string>

namespace intaglio::link {

struct ExpectedDevice {
  std::string serial_number = {};  ///< empty: any device is accepted
  std::string kind = {};           ///< for messages, e.g. "laser"
  std::string cell = {};           ///< name of the machine profile, e.g. "els-03"
  std::string device = {};         ///< e.g. "/dev/ttyUSB0"
  std::string line = {};           ///< field of the profile, e.g. "laser_line"

  /// What to do about a device whose identity cannot be read.
  std::string VersionHint() const;
};

/// Why a device that reports `serial_number` (empty: it has none) is refused, and what to
/// do; empty when it is the expected one.
std::string RefusalOf(const ExpectedDevice& expected, const std::string& serial_number);

}  // namespace intaglio::link
