#pragma once

// The host's end of a line to a device, or the device's: bytes out, bytes in. What
// carries them is behind this interface; endpoint.h opens one by the text of a machine
// profile.
//
// Every implementation that endpoint.h lists guarantees this, and
// tests/services/platform/link/endpoint_test.cc checks it for each of them:
//   E1  Bytes arrive in the order in which they were written, unchanged, none twice.
//   E2  No call blocks: not Read without bytes, not Write to a peer that reads nothing,
//       not opening, whatever the peer or the network does. No name is resolved.
//   E3  Write takes as much as there is room for and returns how much: a prefix.
//   E4  A peer that closes its end, and a device that is removed, make Read and Write
//       return kLinkLost. The stream stays lost; the error names the line and the remedy.
//   E5  A device that is absent, refuses or does not answer is an error of opening or of
//       the first Read, which names the line and the remedy.
//   E6  One host at a time: a second opening of the same line gets an error, by opening
//       it or by its first Reads, and does not disturb the first one.
//   E7  Destroying a stream closes it; the peer notices at once. So it is when the
//       process is killed.
//   E8  A line that was lost can be opened again, and delivers nothing of the time
//       before.
//   E9  No signal is raised, e.g. SIGPIPE.
// Not thread-safe.

#include <cstddef>
#include <span>

#include "engrave/core/result.h"

namespace intaglio::link {

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Bytes read into `buffer`; 0 when there are none; kLinkLost when the line is gone.
  virtual Result<std::size_t> Read(std::span<std::byte> buffer) = 0;
  /// Bytes taken (maybe fewer than given); kLinkLost when the line is gone.
  virtual Result<std::size_t> Write(std::span<const std::byte> bytes) = 0;
  /// For poll(2); -1 when there is none.
  virtual int fd() const = 0;
  /// False while the connection is being made; then nothing is read and nothing taken.
  virtual bool connected() const { return true; }
};

}  // namespace intaglio::link
