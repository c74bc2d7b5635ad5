#include "services/motion_bridge/laser_socket.h"

#include <string_view>
#include <utility>

namespace intaglio::motion_bridge {
namespace {

constexpr std::string_view kScheme = "unix:";
constexpr std::chrono::milliseconds kListenAgain{500};

}  // namespace

LaserSocket::LaserSocket(drivers::LaserController& laser, std::string device,
                         link::SteadyClock clock)
    : laser_(laser),
      output_(laser, clock),
      device_(std::move(device)),
      clock_(std::move(clock)) {}

void LaserSocket::Listen() {
  if (clock_() < next_listen_) return;
  next_listen_ = clock_() + kListenAgain;
  if (!device_.starts_with(kScheme)) {
    message_ = "laser_line.device \"" + device_ +
               "\" cannot be served: give unix:/PATH, or nothing for the usual one";
    return;
  }
  auto made = link::UnixListener::Listen(device_.substr(kScheme.size()));
  if (made) {
    listener_ = std::move(*made);
    message_.clear();
  } else {
    message_ = "laser_line: " + made.error().message;
  }
}

void LaserSocket::AcceptHosts() {
  while (auto host = listener_->Accept()) {
    // Dropped: its line is closed.
    if (output_.ready() && !output_.has_host()) output_.Plug(std::move(host));
  }
}

void LaserSocket::Turn() {
  if (!closing_ && !listener_) Listen();
  output_.Poll();
  if (listener_) AcceptHosts();
}

void LaserSocket::Close() {
  closing_ = true;
  listener_.reset();
  output_.Close();
}

std::array<int, 2> LaserSocket::descriptors() const {
  return {output_.fd(), listener_ ? listener_->fd() : -1};
}

}  // namespace intaglio::motion_bridge
