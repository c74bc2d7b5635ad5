#include "tests/integration/tcp_relay.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <vector>

namespace intaglio::testing {
namespace {

sockaddr_in Loopback(std::uint16_t port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return at;
}

/// One connection on both sides of the relay.
struct Pair {
  int host = -1, machine = -1;

  /// False when one side has closed.
  static bool Carry(int from, int to) {
    std::array<char, 16384> buffer;
    for (;;) {
      const ssize_t got = recv(from, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (got == 0) return false;
      if (got < 0) return errno == EAGAIN;
      for (ssize_t sent = 0; sent < got;) {
        const ssize_t now = send(to, buffer.data() + sent,
                                 static_cast<std::size_t>(got - sent), MSG_NOSIGNAL);
        if (now < 0) return false;
        sent += now;
      }
    }
  }
  bool Carry() const { return Carry(host, machine) && Carry(machine, host); }
  void Close() const {
    close(host);
    close(machine);
  }
};

}  // namespace

TcpRelay::TcpRelay(const std::string& device)
    : to_port_(
          static_cast<std::uint16_t>(std::stoi(device.substr(device.rfind(':') + 1)))),
      listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in at = Loopback(0);
  socklen_t size = sizeof at;
  if (bind(listener_, reinterpret_cast<sockaddr*>(&at), size) != 0 ||
      listen(listener_, 5) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size) != 0)
    throw std::runtime_error("no port for a relay");
  own_port_ = ntohs(at.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

TcpRelay::~TcpRelay() {
  thread_.request_stop();
  thread_.join();
  close(listener_);
}

std::string TcpRelay::device() const {
  return "tcp:127.0.0.1:" + std::to_string(own_port_);
}

void TcpRelay::Run(const std::stop_token& stop) {
  std::vector<Pair> pairs;
  while (!stop.stop_requested()) {
    std::vector<pollfd> ready = {{listener_, POLLIN, 0}};
    for (const Pair& pair : pairs) {
      ready.push_back({pair.host, POLLIN, 0});
      ready.push_back({pair.machine, POLLIN, 0});
    }
    if (holds_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    poll(ready.data(), ready.size(), 5);
    Pair fresh;
    fresh.host = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fresh.host >= 0) {
      fresh.machine = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in to = Loopback(to_port_);
      const int yes = 1;
      for (const int fd : {fresh.host, fresh.machine})
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      if (connect(fresh.machine, reinterpret_cast<const sockaddr*>(&to), sizeof to) ==
          0) {
        pairs.push_back(fresh);
      } else {
        fresh.Close();
      }
    }
    std::erase_if(pairs, [](const Pair& pair) {
      if (pair.Carry()) return false;
      pair.Close();
      return true;
    });
  }
  for (const Pair& pair : pairs) pair.Close();
}

}  // namespace intaglio::testing
