#pragma once

// Lines to devices by the form of their text in a machine profile (laser_line.device,
// motion_line.device):
//
//   serial:/dev/ttyUSB0   a serial port or pseudo-terminal; a path alone is one, too
//   tcp:192.168.7.20:5000 a device that listens on a TCP port; tcp:[fd00::20]:5000
//   unix:/run/intaglio/els-03.laser  a program of this computer that stands for a device
//   usb:9588:9899         a device on USB by vendor and product, of those of
//   usb_device.h;
//                         usb:9588:9899@1-2.3 the one at this place
//
// An implementation is one header, one source, one row of the table in endpoint.cc and
// one peer in tests/services/platform/link/endpoint_peers.cc. What it guarantees:
// byte_stream.h.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "services/platform/link/byte_stream.h"

namespace intaglio::link {

/// Opens a line; called again, at most twice a second, after each loss of it.
using StreamOpener = std::function<Result<std::unique_ptr<ByteStream>>()>;

struct EndpointKind {
  std::string_view scheme;  ///< before the first ':', lower case
  std::string_view form;    ///< for messages, e.g. "serial:/dev/ttyUSB0"
  /// kInvalidValue, with a sentence, when what follows the scheme cannot be an address.
  Status (*check)(const std::string& address);
  /// `baud` applies to serial ports only.
  Result<std::unique_ptr<ByteStream>> (*open)(const std::string& address,
                                              std::uint32_t baud);
};

/// All there are.
std::span<const EndpointKind> EndpointKinds();

/// kInvalidValue when `device` is of no known form; the message lists the known ones.
/// Opens nothing.
Status CheckDevice(const std::string& device);

/// kInvalidValue as CheckDevice, kIo when it cannot be opened. A stream that is returned
/// may still be connecting.
Result<std::unique_ptr<ByteStream>> OpenEndpoint(const std::string& device,
                                                 std::uint32_t baud);

/// OpenEndpoint with these arguments, again and again.
StreamOpener EndpointOpener(std::string device, std::uint32_t baud);

}  // namespace intaglio::link
