#include "tests/services/platform/link/endpoint_peers.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "tests/test_folder.h"

namespace intaglio::link {
namespace {

void Close(int& descriptor) {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

std::vector<std::byte> ReadFrom(int descriptor, std::size_t count) {
  std::vector<std::byte> bytes(count);
  const ssize_t got = descriptor < 0 ? 0 : read(descriptor, bytes.data(), count);
  bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return bytes;
}

class PtyPeer final : public EndpointPeer {
 public:
  PtyPeer() : link_(test::FreshFolder() / "line") { ComeBack(); }
  ~PtyPeer() override { Remove(); }

  std::string device() const override { return "serial:" + link_.string(); }
  std::string name() const override { return link_.string(); }
  std::vector<std::byte> Read(std::size_t count) override {
    return ReadFrom(master_, count);
  }
  std::size_t Write(std::span<const std::byte> bytes) override {
    const ssize_t taken = write(master_, bytes.data(), bytes.size());
    return taken > 0 ? static_cast<std::size_t>(taken) : 0;
  }
  void Serve() override {}
  bool HostIsGone() override {
    pollfd state{master_, 0, 0};
    return poll(&state, 1, 0) >= 0 && (state.revents & POLLHUP) != 0;
  }
  void Remove() override {
    std::filesystem::remove(link_);
    Close(master_);
  }
  void ComeBack() override {
    int slave = -1;
    std::array<char, 256> path{};
    if (openpty(&master_, &slave, path.data(), nullptr, nullptr) != 0)
      throw std::runtime_error("no pseudo-terminal");
    close(slave);
    fcntl(master_, F_SETFL, O_RDWR | O_NONBLOCK);
    std::filesystem::create_symlink(path.data(), link_);
  }

 private:
  std::filesystem::path link_;
  int master_ = -1;
};

class TcpPeer final : public EndpointPeer {
 public:
  TcpPeer() { ComeBack(); }
  ~TcpPeer() override { Remove(); }

  std::string device() const override { return "tcp:" + name(); }
  std::string name() const override { return "127.0.0.1:" + std::to_string(port_); }
  std::vector<std::byte> Read(std::size_t count) override {
    Serve();
    return ReadFrom(host_, count);
  }
  std::size_t Write(std::span<const std::byte> bytes) override {
    Serve();
    const ssize_t taken = send(host_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return taken > 0 ? static_cast<std::size_t>(taken) : 0;
  }
  void Serve() override {
    for (;;) {
      int next = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (next < 0) return;
      if (host_ >= 0 && HostIsGone()) Close(host_);
      host_ < 0 ? host_ = next : close(next);
    }
  }
  bool HostIsGone() override {
    if (host_ < 0) return false;
    pollfd state{host_, POLLRDHUP, 0};
    return poll(&state, 1, 0) > 0;
  }
  void Remove() override {
    Close(listener_);
    Close(host_);
  }
  void ComeBack() override {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int yes = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port_);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0 ||
        listen(listener_, 5) != 0)
      throw std::runtime_error("no port");
    socklen_t size = sizeof at;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size);
    port_ = ntohs(at.sin_port);
  }

 private:
  int listener_ = -1, host_ = -1;
  std::uint16_t port_ = 0;
};

class UnixPeer : public EndpointPeer {
 public:
  UnixPeer() { ComeBack(); }
  ~UnixPeer() override {
    Remove();
    std::filesystem::remove_all(folder_);
  }

  std::string device() const override { return "unix:" + path_; }
  std::string name() const override { return path_; }
  std::vector<std::byte> Read(std::size_t count) override {
    Serve();
    return ReadFrom(host_, count);
  }
  std::size_t Write(std::span<const std::byte> bytes) override {
    Serve();
    const ssize_t taken = send(host_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return taken > 0 ? static_cast<std::size_t>(taken) : 0;
  }
  void Serve() override {
    for (;;) {
      int next = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (next < 0) return;
      if (host_ >= 0 && HostIsGone()) Close(host_);
      host_ < 0 ? host_ = next : close(next);
    }
  }
  bool HostIsGone() override {
    if (host_ < 0) return false;
    pollfd state{host_, POLLRDHUP, 0};
    return poll(&state, 1, 0) > 0;
  }
  // As of a program that was killed: its file stays.
  void Remove() override {
    Close(listener_);
    Close(host_);
  }
  void ComeBack() override {
    std::filesystem::remove(path_);
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    path_.copy(at.sun_path, sizeof at.sun_path - 1);
    if (bind(listener_, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0 ||
        listen(listener_, 5) != 0)
      throw std::runtime_error("no socket");
  }

 protected:
  const std::string& folder() const { return folder_; }
  const std::string& path() const { return path_; }

 private:
  // The folders of tests are longer than a socket's path may be.
  static std::string ShortFolder() {
    std::string made = "/tmp/intaglio-peer-XXXXXX";
    if (mkdtemp(made.data()) == nullptr) throw std::runtime_error("no folder");
    return made;
  }

  int listener_ = -1, host_ = -1;
  std::string folder_ = ShortFolder();
  std::string path_ = folder_ + "/1-2.3";
};

// A socket behind fake_libusb.cc, which has a device for each file of its folder.
class UsbPeer final : public UnixPeer {
 public:
  UsbPeer() { setenv("INTAGLIO_FAKE_USB", folder().c_str(), 1); }
  ~UsbPeer() override { unsetenv("INTAGLIO_FAKE_USB"); }
  std::string device() const override { return "usb:" + name(); }
  std::string name() const override { return "9588:9899"; }
  void Remove() override {
    UnixPeer::Remove();
    std::filesystem::remove(path());
  }
};

}  // namespace

std::unique_ptr<EndpointPeer> MakePeer(std::string_view scheme) {
  if (scheme == "serial") return std::make_unique<PtyPeer>();
  if (scheme == "tcp") return std::make_unique<TcpPeer>();
  if (scheme == "unix") return std::make_unique<UnixPeer>();
  if (scheme == "usb") return std::make_unique<UsbPeer>();
  return nullptr;
}

}  // namespace intaglio::link
