// Any text as the address of a line: an error with a message, or an address whose text is
// read as the same address.

#include <cstdint>
#include <string>

#include "engrave/core/check.h"
#include "services/platform/link/tcp_stream.h"
#include "services/platform/link/usb_device.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  if (const auto address = link::ParseTcpAddress(text)) {
    const std::string written = address->text();
    Require(written.starts_with("tcp:"), "another kind");
    const auto again = link::ParseTcpAddress(written.substr(4));
    Require(again && again->text() == written, "another address");
  } else {
    Require(!address.error().message.empty(), "an error without a sentence");
  }
  if (const auto address = link::ParseUsbAddress(text)) {
    Require(address->kind != nullptr, "an unknown device");
    Require(address->place.find('/') == std::string::npos, "a place is no path");
  } else {
    Require(!address.error().message.empty(), "an error without a sentence");
  }
  return 0;
}
