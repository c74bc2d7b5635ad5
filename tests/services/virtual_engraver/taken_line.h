#pragma once

// A foreign host at a machine's line, which sends one message to it: that it is the
// newest host.

#include <fcntl.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "services/platform/link/byte_codec.h"
#include "services/platform/link/frame.h"

namespace intaglio::virtual_engraver {

/// False when the line does not take it. Passes by every lock, as another computer's
/// cable would.
inline bool TakeLineOver(const std::string& line) {
  constexpr std::uint8_t kOpen = 0x01;
  link::ByteWriter epoch;
  epoch.Put(std::uint64_t{1} << 40);
  std::vector<std::byte> frame;
  link::AppendFrame({kOpen, 0xF0E1D2C3, 0, 1, 256}, epoch.Take(), frame);
  const int descriptor = open(line.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool sent =
      write(descriptor, frame.data(), frame.size()) == static_cast<ssize_t>(frame.size());
  close(descriptor);
  return sent;
}

}  // namespace intaglio::virtual_engraver
