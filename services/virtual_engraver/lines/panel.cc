#include "services/virtual_engraver/lines/panel.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace intaglio::virtual_engraver {
namespace {
constexpr std::size_t kMaxLine = 1024;
constexpr std::size_t kMaxGuests = 8;
}  // namespace

// A socket's path has room for 107 characters; folders can be deeper. Through the
// folder's own descriptor every path is short.
Result<Panel> Panel::Open(const std::filesystem::path& socket_path) {
  const std::filesystem::path folder =
      socket_path.has_parent_path() ? socket_path.parent_path() : ".";
  const int folder_fd = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  const std::string path =
      fmt::format("/proc/self/fd/{}/{}", folder_fd, socket_path.filename().string());
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  unlink(socket_path.c_str());
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool open =
      folder_fd >= 0 && listener >= 0 &&
      bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      listen(listener, static_cast<int>(kMaxGuests)) == 0;
  const std::string why = std::strerror(errno);
  if (folder_fd >= 0) close(folder_fd);
  if (open) return Panel(socket_path, listener);
  if (listener >= 0) close(listener);
  return Fail(ErrorCode::kIo,
              fmt::format("cannot open the panel {}: {}", socket_path.string(), why),
              socket_path.string());
}

Panel::Panel(Panel&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      listener_(std::exchange(other.listener_, -1)),
      guests_(std::exchange(other.guests_, {})) {}

Panel::~Panel() {
  for (const Guest& guest : guests_) close(guest.fd);
  if (listener_ < 0) return;
  close(listener_);
  unlink(path_.c_str());
}

std::vector<int> Panel::fds() const {
  std::vector<int> all = {listener_};
  for (const Guest& guest : guests_) all.push_back(guest.fd);
  return all;
}

void Panel::Poll(const Answer& answer) {
  const int fd = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd >= 0) {
    if (guests_.size() < kMaxGuests) {
      guests_.push_back({fd, {}});
    } else {
      close(fd);
    }
  }
  std::erase_if(guests_, [&](Guest& guest) {
    if (Serve(guest, answer)) return false;
    close(guest.fd);
    return true;
  });
}

bool Panel::Serve(Guest& guest, const Answer& answer) {
  std::array<char, kMaxLine> buffer;
  const ssize_t got = read(guest.fd, buffer.data(), buffer.size());
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
  if (got > 0) guest.unread.append(buffer.data(), static_cast<std::size_t>(got));
  for (;;) {
    const auto end = guest.unread.find('\n');
    if (end == std::string::npos) return guest.unread.size() < kMaxLine;
    const std::string reply = answer(guest.unread.substr(0, end)) + "\n";
    guest.unread.erase(0, end + 1);
    if (send(guest.fd, reply.data(), reply.size(), MSG_NOSIGNAL) < 0) return false;
  }
}

}  // namespace intaglio::virtual_engraver
