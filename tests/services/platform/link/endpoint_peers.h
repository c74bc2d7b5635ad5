#pragma once

// The device's end of a line of each kind that endpoint.h lists, made of the system's
// calls alone.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::link {

class EndpointPeer {
 public:
  virtual ~EndpointPeer() = default;
  /// What a host opens.
  virtual std::string device() const = 0;
  /// A part of it that every message about this line has to contain.
  virtual std::string name() const = 0;
  /// At most `count` bytes that have come; never blocks.
  virtual std::vector<std::byte> Read(std::size_t count) = 0;
  /// How many of them were taken; never blocks. Without a host: as the line does it.
  virtual std::size_t Write(std::span<const std::byte> bytes) = 0;
  /// The device takes its hosts, and turns a second one away.
  virtual void Serve() = 0;
  /// The host there was has closed its end.
  virtual bool HostIsGone() = 0;
  /// The device is removed, and comes back under the same name.
  virtual void Remove() = 0;
  virtual void ComeBack() = 0;
};

/// Null for a kind that has none: the conformance test fails for it.
std::unique_ptr<EndpointPeer> MakePeer(std::string_view scheme);

}  // namespace intaglio::link
