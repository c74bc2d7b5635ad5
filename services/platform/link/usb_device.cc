#include "services/platform/link/usb_device.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <utility>
#include <vector>

#include "engrave/core/try.h"

namespace intaglio::link {
namespace {

constexpr std::array kUsbKinds = {
    // galvoplotter and meerk40t: its interface 0, bulk.
    UsbKind{0x9588, 0x9899, 0x02, 0x88, "BJJCZ board"},
};
constexpr int kUsbInterface = 0;

std::string UsbNumbers(const UsbKind& kind) {
  return fmt::format("{:04x}:{:04x}", kind.vendor, kind.product);
}

// One for the process: it has a thread that follows the bus.
Result<libusb_context*> UsbContext() {
  static libusb_context* context = nullptr;
  if (context != nullptr) return context;
  const int error = libusb_init(&context);
  if (error == LIBUSB_SUCCESS) return context;
  context = nullptr;
  return Fail(ErrorCode::kIo,
              fmt::format("USB cannot be used ({}): check that this computer has USB and "
                          "that /dev/bus/usb is there",
                          libusb_error_name(error)));
}

// As the kernel names it.
std::string UsbPlace(libusb_device* device) {
  std::array<std::uint8_t, 7> ports{};
  const int count =
      libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string place = fmt::format("{}", libusb_get_bus_number(device));
  for (int i = 0; i < count; ++i)
    place += (i == 0 ? "-" : ".") + std::to_string(ports.at(static_cast<std::size_t>(i)));
  return place;
}

class UsbList {
 public:
  explicit UsbList(libusb_context* context)
      : count_(libusb_get_device_list(context, &devices_)) {}
  UsbList(const UsbList&) = delete;
  UsbList& operator=(const UsbList&) = delete;
  ~UsbList() {
    if (devices_ != nullptr) libusb_free_device_list(devices_, 1);
  }
  /// Those of the address, by their place.
  std::vector<std::pair<std::string, libusb_device*>> Matching(
      const UsbAddress& address) const {
    std::vector<std::pair<std::string, libusb_device*>> all;
    for (libusb_device* device : std::span(devices_, count_ > 0 ? count_ : 0)) {
      libusb_device_descriptor about{};
      if (libusb_get_device_descriptor(device, &about) != LIBUSB_SUCCESS) continue;
      if (about.idVendor != address.kind->vendor ||
          about.idProduct != address.kind->product)
        continue;
      const std::string place = UsbPlace(device);
      if (address.place.empty() || place == address.place)
        all.emplace_back(place, device);
    }
    std::ranges::sort(all);
    return all;
  }

 private:
  libusb_device** devices_ = nullptr;
  ssize_t count_;
};

Error UsbOpenError(const std::string& name, int error) {
  const char* remedy = "check the cable and its power";
  if (error == LIBUSB_ERROR_ACCESS)
    remedy =
        "this user may not open it: check that the udev rule 70-intaglio-usb.rules is "
        "installed (deploy/udev, /lib/udev/rules.d) and that the user is in the group "
        "dialout, then plug the device in again";
  if (error == LIBUSB_ERROR_BUSY)
    remedy = "another program has it: end that one, and check that one cell names it";
  return {ErrorCode::kIo,
          fmt::format("USB device {} cannot be opened ({}): {}", name,
                      libusb_error_name(error), remedy),
          name};
}

Result<libusb_device_handle*> ClaimUsb(libusb_device* device, const std::string& name) {
  libusb_device_handle* handle = nullptr;
  if (const int error = libusb_open(device, &handle); error != LIBUSB_SUCCESS)
    return tl::unexpected(UsbOpenError(name, error));
  (void)libusb_set_auto_detach_kernel_driver(handle, 1);
  if (const int error = libusb_claim_interface(handle, kUsbInterface);
      error != LIBUSB_SUCCESS) {
    libusb_close(handle);
    return tl::unexpected(UsbOpenError(name, error));
  }
  return handle;
}

bool IsUsbNumber(std::string_view text, std::uint16_t& number) {
  const auto end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number, 16);
  return text.size() == 4 && read.ec == std::errc() && read.ptr == end;
}

}  // namespace

Result<UsbAddress> ParseUsbAddress(const std::string& text) {
  const auto at = text.find('@');
  const std::string_view numbers = std::string_view(text).substr(0, at);
  std::uint16_t vendor = 0, product = 0;
  if (numbers.size() != 9 || numbers[4] != ':' ||
      !IsUsbNumber(numbers.substr(0, 4), vendor) ||
      !IsUsbNumber(numbers.substr(5), product)) {
    return Fail(ErrorCode::kInvalidValue,
                "vendor and product are to be four hexadecimal digits each, as lsusb "
                "prints them");
  }
  UsbAddress address;
  std::string known;
  for (const UsbKind& kind : kUsbKinds) {
    if (kind.vendor == vendor && kind.product == product) address.kind = &kind;
    known +=
        fmt::format("{}{} ({})", known.empty() ? "" : ", ", UsbNumbers(kind), kind.name);
  }
  if (address.kind == nullptr) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a USB device {} is not known; there are: {}", numbers, known));
  }
  if (at == std::string::npos) return address;
  address.place = text.substr(at + 1);
  const auto dash = address.place.find('-');
  const bool has_form =
      dash != std::string::npos && dash > 0 && dash + 1 < address.place.size() &&
      address.place.find_first_not_of("0123456789-.") == std::string::npos;
  if (has_form) return address;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("'{}' is no place on USB: give bus and ports as the folders of "
                          "/sys/bus/usb/devices have them, e.g. 1-2.3",
                          address.place));
}

Result<std::unique_ptr<UsbDevice>> UsbDevice::Open(const UsbAddress& address) {
  static std::atomic<std::size_t> opened_before{0};
  const UsbList list(INTAGLIO_TRY(UsbContext()));
  const auto devices = list.Matching(address);
  std::string name = UsbNumbers(*address.kind);
  if (devices.empty()) {
    if (!address.place.empty()) name += " at " + address.place;
    return Fail(ErrorCode::kIo,
                fmt::format("no USB device {} ({}) is there: check its power and the "
                            "cable; lsusb lists what is there",
                            name, address.kind->name),
                name);
  }
  const std::size_t first = opened_before;
  Error error;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const auto& [place, device] = devices[(first + i) % devices.size()];
    const std::string here = name + " at " + place;
    const auto handle = ClaimUsb(device, here);
    if (!handle) {
      error = handle.error();
      continue;
    }
    opened_before = first + i + 1;
    return std::unique_ptr<UsbDevice>(new UsbDevice(*handle, *address.kind, here));
  }
  return tl::unexpected(error);
}

UsbDevice::UsbDevice(libusb_device_handle* handle, const UsbKind& kind, std::string name)
    : handle_(handle), kind_(kind), name_(std::move(name)) {}

UsbDevice::~UsbDevice() {
  (void)libusb_release_interface(handle_, kUsbInterface);
  libusb_close(handle_);
}

Result<std::size_t> UsbDevice::Send(std::span<const std::byte> bytes,
                                    std::chrono::milliseconds timeout) {
  // libusb writes nothing into what it sends.
  auto* data =
      const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(bytes.data()));
  return Transfer(kind_.out_endpoint, data, bytes.size(), timeout);
}

Result<std::size_t> UsbDevice::Receive(std::span<std::byte> buffer,
                                       std::chrono::milliseconds timeout) {
  return Transfer(kind_.in_endpoint, reinterpret_cast<unsigned char*>(buffer.data()),
                  buffer.size(), timeout);
}

Result<std::size_t> UsbDevice::Transfer(std::uint8_t endpoint, unsigned char* bytes,
                                        std::size_t count,
                                        std::chrono::milliseconds timeout) {
  int moved = 0;
  const int error =
      libusb_bulk_transfer(handle_, endpoint, bytes, static_cast<int>(count), &moved,
                           static_cast<unsigned>(timeout.count()));
  if (error == LIBUSB_SUCCESS || error == LIBUSB_ERROR_TIMEOUT ||
      error == LIBUSB_ERROR_INTERRUPTED)
    return static_cast<std::size_t>(std::max(0, moved));
  return Fail(ErrorCode::kLinkLost,
              fmt::format("the USB device {} is gone ({}): check the cable and its power",
                          name_, libusb_error_name(error)),
              name_);
}

}  // namespace intaglio::link
