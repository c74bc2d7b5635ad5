#pragma once

// A USB device (usb_device.h) as a stream of bytes. What one Write takes is one transfer,
// so a protocol whose packets are transfers writes each by a call of its own. What an
// earlier host has asked and did not read is dropped before it is connected().
//
// A thread sends and a thread receives; little waits between them and their callers, so
// what was written before the line was cut, and arrives behind it, is little, too.

#include <memory>
#include <string>

#include "services/platform/link/byte_stream.h"

namespace intaglio::link {

/// kInvalidValue: `text` is no address of usb_device.h.
Status CheckUsb(const std::string& text);

/// UsbDevice::Open. Destroying it takes 20 ms at most.
Result<std::unique_ptr<ByteStream>> OpenUsb(const std::string& text);

}  // namespace intaglio::link
