#pragma once

// A serial device (or pseudo-terminal), raw and non-blocking.

#include <cstdint>
#include <memory>
#include <string>

#include "services/platform/link/byte_stream.h"

namespace intaglio::link {

/// 8 data bits, no parity, no flow control. `baud` is one of the usual rates from 1200
/// to 4000000; pseudo-terminals ignore it. No other process of this machine has it open
/// by this function at the same time. Errors name the device and the remedy.
Result<std::unique_ptr<ByteStream>> OpenSerialPort(const std::string& device,
                                                   std::uint32_t baud);

/// Takes over an open descriptor, which is made non-blocking; `name` is for messages.
std::unique_ptr<ByteStream> WrapDescriptor(int descriptor, const std::string& name);

}  // namespace intaglio::link
