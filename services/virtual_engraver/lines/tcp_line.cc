#include "services/virtual_engraver/lines/tcp_line.h"

#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include "engrave/core/try.h"
#include "services/platform/link/tcp_stream.h"

namespace intaglio::virtual_engraver {
namespace {

// Closed so that the peer gets a reset: there is nothing that it may wait for.
void TurnAway(int socket) {
  const linger at_once{1, 0};
  (void)setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(socket);
}

}  // namespace

struct TcpLine::Socket {
  Socket(int listening, std::string its_name)
      : listener(listening), name(std::move(its_name)) {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { CloseListener(); }

  void CloseListener() {
    if (listener >= 0) close(listener);
    listener = -1;
  }
  void Serve() {
    while (!gone && listener >= 0) {
      const int next = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
      if (next < 0) return;
      if (host) {
        TurnAway(next);
      } else {
        host = link::WrapTcpSocket(next, name);
      }
    }
  }
  void Lose() {
    host.reset();
    gone = true;
  }

  int listener;
  std::string name;
  std::unique_ptr<link::ByteStream> host;
  bool gone = false;  // and HostHasGone() has not reported it yet
};

class TcpLine::Stream final : public link::ByteStream {
 public:
  explicit Stream(std::shared_ptr<Socket> socket) : socket_(std::move(socket)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    socket_->Serve();
    if (!socket_->host) return std::size_t{0};
    const auto got = socket_->host->Read(buffer);
    if (!got) socket_->Lose();
    return got.value_or(0);
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!socket_->host) return bytes.size();
    const auto taken = socket_->host->Write(bytes);
    if (!taken) socket_->Lose();
    return taken.value_or(bytes.size());
  }
  int fd() const override { return socket_->host ? socket_->host->fd() : -1; }

 private:
  std::shared_ptr<Socket> socket_;
};

Result<TcpLine> TcpLine::Open(const std::string& address, const std::string& name) {
  const auto parsed = link::ParseTcpAddress(address);
  if (!parsed) {
    return Fail(parsed.error().code,
                "cannot make the line tcp:" + address + ": " + parsed.error().message,
                address);
  }
  const auto listener = INTAGLIO_TRY(link::ListenTcp(*parsed));
  return TcpLine(std::make_shared<Socket>(listener, name));
}

TcpLine::TcpLine(std::shared_ptr<Socket> socket) : socket_(std::move(socket)) {}
TcpLine::TcpLine(TcpLine&&) noexcept = default;
TcpLine& TcpLine::operator=(TcpLine&&) noexcept = default;

// A stream of it may live on, but no host can reach it.
TcpLine::~TcpLine() {
  if (!socket_) return;
  socket_->CloseListener();
  socket_->host.reset();
}

bool TcpLine::HostHasGone() { return std::exchange(socket_->gone, false); }

std::string TcpLine::device() const {
  return link::TcpAddressOf(socket_->listener).text();
}

std::array<int, 2> TcpLine::descriptors() const {
  return {socket_->host ? socket_->host->fd() : -1, socket_->listener};
}

std::unique_ptr<link::ByteStream> TcpLine::HostBytes() {
  return std::make_unique<Stream>(socket_);
}

}  // namespace intaglio::virtual_engraver
