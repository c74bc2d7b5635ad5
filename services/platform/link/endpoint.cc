#include "services/platform/link/endpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engrave/core/try.h"
#include "services/platform/link/serial_port.h"
#include "services/platform/link/tcp_stream.h"
#include "services/platform/link/unix_stream.h"
#include "services/platform/link/usb_stream.h"

namespace intaglio::link {
namespace {

Status CheckPath(const std::string& path) {
  if (!path.empty()) return {};
  return Fail(ErrorCode::kInvalidValue, "the path of the serial device is missing");
}

Status CheckTcp(const std::string& text) {
  const auto address = INTAGLIO_TRY(ParseTcpAddress(text));
  if (address.port != 0) return {};
  return Fail(ErrorCode::kInvalidValue, "port 0 cannot be connected to, give 1..65535");
}

Result<std::unique_ptr<ByteStream>> OpenTcpText(const std::string& text, std::uint32_t) {
  const auto address = INTAGLIO_TRY(ParseTcpAddress(text));
  return OpenTcp(address, MonotonicClock());
}

Result<std::unique_ptr<ByteStream>> OpenUnixText(const std::string& path, std::uint32_t) {
  return OpenUnix(path);
}

Result<std::unique_ptr<ByteStream>> OpenUsbText(const std::string& text, std::uint32_t) {
  return OpenUsb(text);
}

constexpr std::array kKinds = {
    EndpointKind{"serial", "serial:/dev/ttyUSB0", &CheckPath, &OpenSerialPort},
    EndpointKind{"tcp", "tcp:192.168.7.20:5000", &CheckTcp, &OpenTcpText},
    EndpointKind{"unix", "unix:/run/intaglio/els-03.laser", &CheckUnixPath,
                 &OpenUnixText},
    EndpointKind{"usb", "usb:9588:9899@1-2.3", &CheckUsb, &OpenUsbText},
};

struct Device {
  const EndpointKind* kind;  // null: of no known one
  std::string address;
};

// A path may have colons of its own; what can be a scheme is lower-case letters and
// digits in front of the first.
Device Divide(const std::string& device) {
  const auto colon = device.find(':');
  const bool has_scheme =
      colon != std::string::npos && colon > 0 &&
      std::all_of(
          device.begin(), device.begin() + static_cast<std::ptrdiff_t>(colon),
          [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); });
  if (!has_scheme) return {&kKinds.front(), device};
  const std::string_view scheme = std::string_view(device).substr(0, colon);
  const auto found = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& kind) {
    return kind.scheme == scheme;
  });
  return {found == kKinds.end() ? nullptr : &*found, device.substr(colon + 1)};
}

}  // namespace

std::span<const EndpointKind> EndpointKinds() { return kKinds; }

Status CheckDevice(const std::string& device) {
  const Device divided = Divide(device);
  std::string why = "it begins with no known kind of line";
  if (divided.kind != nullptr) {
    const auto good = divided.kind->check(divided.address);
    if (good) return {};
    why = good.error().message;
  }
  std::string forms;
  for (const EndpointKind& kind : kKinds)
    forms += (forms.empty() ? "" : " or ") + std::string(kind.form);
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("device \"{}\": {}; give a form such as {}", device, why, forms),
      device);
}

Result<std::unique_ptr<ByteStream>> OpenEndpoint(const std::string& device,
                                                 std::uint32_t baud) {
  INTAGLIO_TRY(CheckDevice(device));
  const Device divided = Divide(device);
  return divided.kind->open(divided.address, baud);
}

StreamOpener EndpointOpener(std::string device, std::uint32_t baud) {
  return [device = std::move(device), baud] { return OpenEndpoint(device, baud); };
}

}  // namespace intaglio::link
