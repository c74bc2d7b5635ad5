#include "services/platform/link/tcp_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::link {
namespace {

// The kernel takes twice as much, half of it for itself: some 16 frames of the longest.
constexpr int kSendBufferBytes = 16 * 1024;
constexpr int kKeepAliveS = 1;
constexpr int kKeepAliveCount = 2;

void Set(int socket, int level, int option, int value) {
  (void)setsockopt(socket, level, option, &value, sizeof value);
}

void Configure(int socket) {
  fcntl(socket, F_SETFL, fcntl(socket, F_GETFL) | O_NONBLOCK);
  fcntl(socket, F_SETFD, FD_CLOEXEC);
  Set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  Set(socket, SOL_SOCKET, SO_SNDBUF, kSendBufferBytes);
  Set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  Set(socket, IPPROTO_TCP, TCP_KEEPIDLE, kKeepAliveS);
  Set(socket, IPPROTO_TCP, TCP_KEEPINTVL, kKeepAliveS);
  Set(socket, IPPROTO_TCP, TCP_KEEPCNT, kKeepAliveCount);
  Set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kTcpSilentMs);
}

struct FreeAddress {
  void operator()(addrinfo* info) const { freeaddrinfo(info); }
};
using SocketAddress = std::unique_ptr<addrinfo, FreeAddress>;

/// Null when the host is not numeric: no name is resolved.
SocketAddress Numeric(const TcpAddress& address) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(address.port);
  if (getaddrinfo(address.host.c_str(), port.c_str(), &hints, &found) != 0)
    return nullptr;
  return SocketAddress(found);
}

// A connection to a free port of this computer may be given that very port for its own
// end; the device could not listen on it any more.
bool IsConnectedToItself(int socket) {
  sockaddr_storage own{}, peer{};
  socklen_t own_size = sizeof own, peer_size = sizeof peer;
  return getsockname(socket, reinterpret_cast<sockaddr*>(&own), &own_size) == 0 &&
         getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &peer_size) == 0 &&
         own_size == peer_size && std::memcmp(&own, &peer, own_size) == 0;
}

class TcpStream final : public ByteStream {
 public:
  /// A connection that is under way, or made (no deadline).
  TcpStream(int socket, std::string name, SteadyClock clock,
            std::optional<std::chrono::nanoseconds> deadline)
      : socket_(socket),
        name_(std::move(name)),
        clock_(std::move(clock)),
        deadline_(deadline) {}
  ~TcpStream() override { close(socket_); }

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    INTAGLIO_TRY(KeepConnecting());
    if (!connected()) return std::size_t{0};
    const ssize_t got = recv(socket_, buffer.data(), buffer.size(), 0);
    if (got > 0) {
      received_ = true;
      return static_cast<std::size_t>(got);
    }
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::size_t{0};
    return buffer.empty() ? Result<std::size_t>(0) : Closed();
  }

  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    INTAGLIO_TRY(KeepConnecting());
    if (!connected()) return std::size_t{0};
    const ssize_t taken = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (taken >= 0) return static_cast<std::size_t>(taken);
    if (errno == EAGAIN || errno == EINTR) return std::size_t{0};
    return Closed();
  }

  int fd() const override { return socket_; }
  bool connected() const override { return !deadline_; }

 private:
  Status KeepConnecting() {
    if (lost_) return tl::unexpected(*lost_);
    if (connected()) return {};
    pollfd state{socket_, POLLOUT, 0};
    if (poll(&state, 1, 0) == 1) {
      int error = 0;
      socklen_t size = sizeof error;
      (void)getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size);
      if (error == 0 && IsConnectedToItself(socket_)) error = ECONNREFUSED;
      if (error != 0) return CannotConnect(std::strerror(error));
      deadline_.reset();
    } else if (clock_() >= *deadline_) {
      return CannotConnect(fmt::format("no answer within {} ms", kTcpSilentMs));
    }
    return {};
  }

  tl::unexpected<Error> CannotConnect(const std::string& why) {
    return Lose(fmt::format(
        "cannot connect to {}: {}; check that the device is switched on and listens on "
        "this port, the network cable, and the profile's device",
        name_, why));
  }
  tl::unexpected<Error> Closed() {
    return Lose(
        received_
            ? fmt::format("the line {} is gone: check network and power of the device",
                          name_)
            : fmt::format("{} closed the connection without an answer: it may have "
                          "another host already, end that one; else check address and "
                          "port",
                          name_));
  }
  tl::unexpected<Error> Lose(std::string message) {
    lost_ = Error{ErrorCode::kLinkLost, std::move(message), name_};
    return tl::unexpected(*lost_);
  }

  int socket_;
  std::string name_;
  SteadyClock clock_;
  std::optional<std::chrono::nanoseconds> deadline_;  // of a connection being made
  bool received_ = false;
  std::optional<Error> lost_;
};

tl::unexpected<Error> Invalid(const std::string& text, const std::string& why) {
  return Fail(ErrorCode::kInvalidValue, why, text);
}

tl::unexpected<Error> CannotListen(const TcpAddress& address, const char* why) {
  return Fail(ErrorCode::kIo,
              fmt::format("cannot listen on {}: {}; give an address of this computer and "
                          "a port that no other program has, or 0",
                          address.text(), why),
              address.text());
}

}  // namespace

std::string TcpAddress::text() const {
  return host.find(':') == std::string::npos ? fmt::format("tcp:{}:{}", host, port)
                                             : fmt::format("tcp:[{}]:{}", host, port);
}

Result<TcpAddress> ParseTcpAddress(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return Invalid(text, "the port is missing");
  TcpAddress address{text.substr(0, colon), 0};
  const char* end = text.data() + text.size();
  const auto port = std::from_chars(text.data() + colon + 1, end, address.port);
  if (port.ec != std::errc() || port.ptr != end)
    return Invalid(text, "the port is not a number from 1 to 65535");
  std::string& host = address.host;
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  // The resolver reads a text up to its first zero byte, and "*" as no host.
  const bool is_other = host.find('\0') != std::string::npos || host == "*";
  const SocketAddress found = Numeric(address);
  if (is_other || !found || (found->ai_family == AF_INET6) != bracketed) {
    return Invalid(text, fmt::format("the host \"{}\" is neither localhost nor an IPv4 "
                                     "address nor an IPv6 address in brackets (names are "
                                     "not resolved: `getent hosts NAME` shows the "
                                     "address)",
                                     host));
  }
  return address;
}

Result<std::unique_ptr<ByteStream>> OpenTcp(const TcpAddress& address,
                                            SteadyClock clock) {
  const auto deadline = clock() + std::chrono::milliseconds(kTcpSilentMs);
  const SocketAddress to = Numeric(address);
  const int made = to ? socket(to->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0) : -1;
  if (made < 0) {
    return Fail(ErrorCode::kIo, fmt::format("cannot make a connection to {}: {}",
                                            address.text(), std::strerror(errno)));
  }
  Configure(made);
  auto stream =
      std::make_unique<TcpStream>(made, address.text(), std::move(clock), deadline);
  if (connect(made, to->ai_addr, to->ai_addrlen) != 0 && errno != EINPROGRESS) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot connect to {}: {}; check the profile's device and "
                            "this computer's network",
                            address.text(), std::strerror(errno)),
                address.text());
  }
  return stream;
}

Result<int> ListenTcp(const TcpAddress& address) {
  const SocketAddress at = Numeric(address);
  const int made = at ? socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0) : -1;
  if (made < 0) return CannotListen(address, std::strerror(errno));
  Set(made, SOL_SOCKET, SO_REUSEADDR, 1);
  Configure(made);
  if (bind(made, at->ai_addr, at->ai_addrlen) != 0 || listen(made, 1) != 0) {
    const int why = errno;
    close(made);
    return CannotListen(address, std::strerror(why));
  }
  return made;
}

TcpAddress TcpAddressOf(int listening_socket) {
  sockaddr_storage at{};
  socklen_t size = sizeof at;
  (void)getsockname(listening_socket, reinterpret_cast<sockaddr*>(&at), &size);
  std::array<char, 64> host{}, port{};
  (void)getnameinfo(reinterpret_cast<sockaddr*>(&at), size, host.data(), host.size(),
                    port.data(), port.size(), NI_NUMERICHOST | NI_NUMERICSERV);
  TcpAddress address{host.data(), 0};
  std::from_chars(port.data(), port.data() + std::strlen(port.data()), address.port);
  return address;
}

std::unique_ptr<ByteStream> WrapTcpSocket(int socket, const std::string& name) {
  Configure(socket);
  return std::make_unique<TcpStream>(socket, name, MonotonicClock(), std::nullopt);
}

}  // namespace intaglio::link
