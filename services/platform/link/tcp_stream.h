#pragma once

// A line over TCP: the client's side, and what both sides share.
//
// A frame leaves at once (TCP_NODELAY). Bytes that the peer's computer does not
// acknowledge for kSilentMs, and an idle connection whose peer is gone, lose the line
// (TCP_USER_TIMEOUT, keepalive), so that it is opened anew: silence of the device itself
// is found sooner, by the frames (reliable_link.h). The send buffer is small, as a serial
// port's: what was written before a cut and arrives after it is little. A connection is
// neither encrypted nor authenticated: docs/deployment.md.

#include <cstdint>
#include <memory>
#include <string>

#include "services/platform/link/byte_stream.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::link {

/// How long a connection may take, and bytes may stay unacknowledged. Longer than the 250
/// ms of silence that stop a machine, and than two retransmissions; short enough that a
/// machine whose host lost its power accepts the next host after that time.
inline constexpr int kTcpSilentMs = 2000;

struct TcpAddress {
  std::string host;  ///< numeric, e.g. "127.0.0.1" or "fd00::20"
  std::uint16_t port = 0;

  /// As in a profile: "tcp:127.0.0.1:5000", "tcp:[fd00::20]:5000".
  std::string text() const;
};

/// "HOST:PORT": HOST is an IPv4 address, an IPv6 address in brackets, or "localhost"
/// (127.0.0.1); PORT 0..65535. Other names are refused, since resolving them can take
/// many seconds. kInvalidValue: the reason is in the message.
Result<TcpAddress> ParseTcpAddress(const std::string& text);

/// Begins to connect and returns; port > 0. Read and Write take nothing before the
/// connection is made, and lose the line when it is refused or not made within
/// kTcpSilentMs.
Result<std::unique_ptr<ByteStream>> OpenTcp(const TcpAddress& address, SteadyClock clock);

/// A socket that listens there (0: on a free port), one connection waiting at most. kIo
/// names the address and the remedy.
Result<int> ListenTcp(const TcpAddress& address);

/// The address that a listening socket has; its port is never 0.
TcpAddress TcpAddressOf(int listening_socket);

/// Takes over a connected socket, which is made non-blocking; `name` is for messages.
std::unique_ptr<ByteStream> WrapTcpSocket(int socket, const std::string& name);

}  // namespace intaglio::link
