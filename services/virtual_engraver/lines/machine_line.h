#pragma once

// A plug at the back of the machine, where a host connects: a pseudo-terminal or a TCP
// port. When the host closes its end, or dies, the machine notices at once, as by a
// line's DTR; a host that hangs, and a cable that breaks, are silence.

#include <array>
#include <memory>
#include <string>

#include "services/platform/link/byte_stream.h"

namespace intaglio::virtual_engraver {

class MachineLine {
 public:
  MachineLine();
  MachineLine(MachineLine&&) = default;
  MachineLine& operator=(MachineLine&&) = default;
  virtual ~MachineLine() = default;

  /// The machine's end, over all hosts that come and go: it has no bytes while there is
  /// no host, and takes written bytes all the same. A share of the bytes that come in is
  /// lost (DropBytes). One at a time is used; a new one after each host that has gone.
  std::unique_ptr<link::ByteStream> MachineEnd();
  /// Every byte that comes in is lost with this probability, 0..1; drawn from `seed`.
  void DropBytes(double ratio, unsigned seed);

  /// True once each time when the host has gone; before that the next host is not taken.
  virtual bool HostHasGone() = 0;
  /// What a host has to open: a path, or "tcp:127.0.0.1:40123".
  virtual std::string device() const = 0;
  /// To wait for with poll(2); -1: nothing to wait for.
  virtual std::array<int, 2> descriptors() const = 0;

 protected:
  virtual std::unique_ptr<link::ByteStream> HostBytes() = 0;

 private:
  struct Loss;
  std::shared_ptr<Loss> loss_;
};

/// `device`: a path, of a symbolic link to make for a pseudo-terminal, or "tcp:HOST:PORT"
/// to listen there, with port 0 on a free one. `name` is for messages.
Result<std::unique_ptr<MachineLine>> OpenMachineLine(const std::string& device,
                                                     const std::string& name);

}  // namespace intaglio::virtual_engraver
