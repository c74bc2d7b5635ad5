#include "services/platform/link/shared_line.h"

#include <utility>
#include <vector>

#include "services/platform/link/motion_protocol.h"

namespace intaglio::link {

struct FramePort::Line {
  struct Frame {
    std::uint8_t type;
    std::vector<std::byte> payload;
  };

  Line(StreamOpener open, SteadyClock clock)
      : session(std::move(open), std::move(clock)) {}

  std::size_t PortOf(std::uint8_t type) const {
    const bool motion = type >= static_cast<std::uint8_t>(MotionFrame::kBeginRun);
    return divided && !motion ? 1 : 0;
  }
  // What waits is of the session before when there is a new one.
  void Poll() {
    const std::uint32_t before = session.sessions();
    std::array<std::deque<Frame>, 2> fresh;
    session.Poll([&](std::uint8_t type, std::span<const std::byte> payload) {
      fresh[PortOf(type)].push_back({type, {payload.begin(), payload.end()}});
    });
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (session.sessions() != before) waiting[i].clear();
      for (Frame& frame : fresh[i]) waiting[i].push_back(std::move(frame));
      while (waiting[i].size() > kMaxWaiting) waiting[i].pop_front();
    }
  }

  LineSession session;
  bool divided = false;
  std::array<std::deque<Frame>, 2> waiting;
};

FramePort::FramePort(StreamOpener open, SteadyClock clock)
    : line_(std::make_shared<Line>(std::move(open), std::move(clock))) {}

FramePort::FramePort(std::shared_ptr<Line> line, std::size_t number)
    : line_(std::move(line)), number_(number) {}

std::array<FramePort, 2> FramePort::Divide(StreamOpener open, SteadyClock clock) {
  auto line = std::make_shared<Line>(std::move(open), std::move(clock));
  line->divided = true;
  return {FramePort(line, 0), FramePort(line, 1)};
}

void FramePort::Poll(const ReliableLink::Handler& handler) {
  line_->Poll();
  for (const Line::Frame& frame : std::exchange(line_->waiting[number_], {}))
    handler(frame.type, frame.payload);
}

bool FramePort::CanSend() const { return line_->session.CanSend(); }
Status FramePort::Send(std::uint8_t type, std::span<const std::byte> payload) {
  return line_->session.Send(type, payload);
}
bool FramePort::up() const { return line_->session.up(); }
std::uint32_t FramePort::sessions() const { return line_->session.sessions(); }
int FramePort::fd() const { return line_->session.fd(); }
bool FramePort::fenced() const { return line_->session.fenced(); }
const std::string& FramePort::message() const { return line_->session.message(); }

}  // namespace intaglio::link
