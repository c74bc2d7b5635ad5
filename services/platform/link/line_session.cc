#include "services/platform/link/line_session.h"

namespace intaglio::link {
namespace {
constexpr std::chrono::milliseconds kReopenAfter{500};

const std::string& NoAnswer() {
  static const std::string text =
      "the device does not answer: check that it is switched on and uses version " +
      std::to_string(kFrameVersion) + " of the frames";
  return text;
}
}  // namespace

LineSession::LineSession(StreamOpener open, SteadyClock clock)
    : open_(std::move(open)), clock_(std::move(clock)) {}

void LineSession::TryOpen() {
  if (clock_() < next_open_) return;
  next_open_ = clock_() + kReopenAfter;
  auto stream = open_();
  if (!stream) {
    message_ = stream.error().message;
    return;
  }
  link_ = std::make_unique<ReliableLink>(Side::kHost, std::move(*stream), clock_,
                                         LinkOptions{}, epoch_);
  link_session_ = 0;
  connected_at_.reset();
}

// Not before it had the time to answer: until then the reason of the loss before is the
// better message, as of a device that closes each new connection at once.
void LineSession::KeepDownMessage() {
  if (link_session_ != 0) {
    message_ = "the device no longer sends";
    return;
  }
  if (!link_->connected()) return;
  if (!connected_at_) connected_at_ = clock_();
  if (clock_() - *connected_at_ >= LinkOptions{}.dead_after) message_ = NoAnswer();
}

void LineSession::Poll(const ReliableLink::Handler& handler) {
  if (!link_ && !fenced()) TryOpen();
  if (!link_) return;
  if (const auto polled = link_->Poll(handler); !polled) {
    message_ = polled.error().message;
    link_.reset();
    return;
  }
  if (fenced()) {
    message_ = "another host has taken over this machine";
    link_.reset();
    return;
  }
  if (!link_->up()) return KeepDownMessage();
  message_.clear();
  if (link_->session() != link_session_) {
    link_session_ = link_->session();
    ++sessions_;
  }
}

Status LineSession::Send(std::uint8_t type, std::span<const std::byte> payload) {
  if (!link_) return Fail(ErrorCode::kLinkLost, message_);
  return link_->Send(type, payload);
}

}  // namespace intaglio::link
