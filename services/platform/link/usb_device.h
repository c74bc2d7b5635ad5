#pragma once

// A device on USB that is read and written by bulk transfers, through libusb-1.0. Which
// devices there are is a table of UsbKind: their endpoints are not found out.
//
// Both transfers may be called from a thread each.

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/result.h"

struct libusb_device_handle;

namespace intaglio::link {

struct UsbKind {
  std::uint16_t vendor, product;
  std::uint8_t out_endpoint, in_endpoint;
  std::string_view name;  ///< for messages
};

struct UsbAddress {
  const UsbKind* kind = nullptr;
  /// Bus and ports, as /sys/bus/usb/devices has them: "1-2.3"; empty: any place.
  std::string place;
};

/// "9588:9899" or "9588:9899@1-2.3": vendor and product in hexadecimal digits, and the
/// place. kInvalidValue when it is neither, or of no kind.
Result<UsbAddress> ParseUsbAddress(const std::string& text);

class UsbDevice {
 public:
  /// The device and its interface 0, for this program alone. Without a place each call
  /// begins behind the device that the call before has opened: whoever refuses a device
  /// comes to the next. kIo: there is none, or another program has it, or this user may
  /// not open it; the message names what to do.
  static Result<std::unique_ptr<UsbDevice>> Open(const UsbAddress& address);
  UsbDevice(const UsbDevice&) = delete;
  UsbDevice& operator=(const UsbDevice&) = delete;
  ~UsbDevice();

  /// One transfer. Bytes that were moved when the time was over, 0 maybe; kLinkLost: the
  /// device is gone.
  Result<std::size_t> Send(std::span<const std::byte> bytes,
                           std::chrono::milliseconds timeout);
  Result<std::size_t> Receive(std::span<std::byte> buffer,
                              std::chrono::milliseconds timeout);
  /// "9588:9899 at 1-2.3".
  const std::string& name() const { return name_; }

 private:
  UsbDevice(libusb_device_handle* handle, const UsbKind& kind, std::string name);
  Result<std::size_t> Transfer(std::uint8_t endpoint, unsigned char* bytes,
                               std::size_t count, std::chrono::milliseconds timeout);

  libusb_device_handle* handle_;
  const UsbKind& kind_;
  std::string name_;
};

}  // namespace intaglio::link
