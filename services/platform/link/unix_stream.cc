#include "services/platform/link/unix_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::link {
namespace {

// As of a TCP line: what was written before a cut and arrives after it is little.
constexpr int kUnixSendBytes = 16 * 1024;

sockaddr_un UnixAddress(const std::string& path) {
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  path.copy(at.sun_path, kMaxUnixPath);
  return at;
}

int NewUnixSocket() {
  const int made = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (made >= 0)
    setsockopt(made, SOL_SOCKET, SO_SNDBUF, &kUnixSendBytes, sizeof kUnixSendBytes);
  return made;
}

int ConnectUnix(int made, const std::string& path) {
  const sockaddr_un at = UnixAddress(path);
  return connect(made, reinterpret_cast<const sockaddr*>(&at), sizeof at);
}

class UnixStream final : public ByteStream {
 public:
  UnixStream(int socket, std::string path) : socket_(socket), path_(std::move(path)) {}
  ~UnixStream() override { close(socket_); }

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (buffer.empty()) return std::size_t{0};
    const ssize_t got = recv(socket_, buffer.data(), buffer.size(), 0);
    if (got > 0) {
      received_ = true;
      return static_cast<std::size_t>(got);
    }
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::size_t{0};
    return Lost();
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    const ssize_t taken = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (taken >= 0) return static_cast<std::size_t>(taken);
    if (errno == EAGAIN || errno == EINTR) return std::size_t{0};
    return Lost();
  }
  int fd() const override { return socket_; }

 private:
  tl::unexpected<Error> Lost() const {
    return Fail(
        ErrorCode::kLinkLost,
        received_ ? fmt::format("the line {} is closed: check the program that serves it "
                                "and the line behind it",
                                path_)
                  : fmt::format("{} closed the connection without an answer: the device "
                                "behind it may be down, or it may have another host; "
                                "check the messages of the program that serves it",
                                path_),
        path_);
  }

  int socket_;
  std::string path_;
  bool received_ = false;
};

tl::unexpected<Error> CannotServe(const std::string& path, const std::string& why) {
  return Fail(ErrorCode::kIo, fmt::format("cannot listen on {}: {}", path, why), path);
}

/// Ours alone, made when it is missing.
Status PrepareFolder(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  (void)mkdir(folder.c_str(), 0700);
  struct stat there {};
  if (lstat(folder.c_str(), &there) != 0)
    return CannotServe(path, std::strerror(errno) + std::string("; make its folder"));
  if (!S_ISDIR(there.st_mode) || there.st_uid != geteuid() ||
      (there.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return CannotServe(path, folder +
                                 " is no folder that only this user writes; give "
                                 "another path as laser_line.device");
  }
  return {};
}

bool IsServed(const std::string& path) {
  const int probe = NewUnixSocket();
  if (probe < 0) return false;
  const bool served = ConnectUnix(probe, path) == 0 || errno == EAGAIN;
  close(probe);
  return served;
}

}  // namespace

Status CheckUnixPath(const std::string& path) {
  if (!path.starts_with('/'))
    return Fail(ErrorCode::kInvalidValue, "the path of the socket must begin with /");
  if (path.size() <= kMaxUnixPath) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("the path of the socket has {} bytes, {} are the most",
                          path.size(), kMaxUnixPath));
}

Result<std::unique_ptr<ByteStream>> OpenUnix(const std::string& path) {
  INTAGLIO_TRY(CheckUnixPath(path));
  const int made = NewUnixSocket();
  if (made >= 0 && ConnectUnix(made, path) == 0)
    return std::make_unique<UnixStream>(made, path);
  const int why = errno;
  if (made >= 0) close(made);
  return Fail(ErrorCode::kIo,
              fmt::format("cannot connect to {}: {}; check that the program that serves "
                          "it runs (of a laser: the motion bridge of this machine), as "
                          "the same user",
                          path, std::strerror(why)),
              path);
}

Result<std::unique_ptr<UnixListener>> UnixListener::Listen(const std::string& path) {
  INTAGLIO_TRY(CheckUnixPath(path));
  INTAGLIO_TRY(PrepareFolder(path));
  if (IsServed(path))
    return CannotServe(path, "another program serves it already; end that one");
  // Under another name first: whoever finds the file can connect.
  const std::string fresh =
      path.substr(0, path.rfind('/') + 1) + std::to_string(getpid());
  (void)unlink(fresh.c_str());
  const int made = NewUnixSocket();
  const sockaddr_un at = UnixAddress(fresh);
  if (made < 0 || fchmod(made, 0600) != 0 ||
      bind(made, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      chmod(fresh.c_str(), 0600) != 0 || listen(made, 1) != 0 ||
      rename(fresh.c_str(), path.c_str()) != 0) {
    const int why = errno;
    if (made >= 0) close(made);
    (void)unlink(fresh.c_str());
    return CannotServe(path, std::strerror(why));
  }
  return std::unique_ptr<UnixListener>(new UnixListener(made, path));
}

UnixListener::UnixListener(int socket, std::string path)
    : socket_(socket), path_(std::move(path)) {}

// Not that of a program which replaced it.
UnixListener::~UnixListener() {
  close(socket_);
  if (!IsServed(path_)) (void)unlink(path_.c_str());
}

std::unique_ptr<ByteStream> UnixListener::Accept() {
  const int next = accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (next < 0) return nullptr;
  setsockopt(next, SOL_SOCKET, SO_SNDBUF, &kUnixSendBytes, sizeof kUnixSendBytes);
  return std::make_unique<UnixStream>(next, path_);
}

}  // namespace intaglio::link
