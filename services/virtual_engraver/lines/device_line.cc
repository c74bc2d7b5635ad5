#include "services/virtual_engraver/lines/device_line.h"

namespace intaglio::virtual_engraver {

void DeviceLine::Plug(std::unique_ptr<link::ByteStream> end,
                      const link::SteadyClock& clock, bool waits) {
  waiting_.clear();
  link_.reset();
  link::LinkOptions options;
  options.waits = waits;
  if (end) {
    link_ = std::make_unique<link::ReliableLink>(link::Side::kDevice, std::move(end),
                                                 clock, options, epoch_);
  }
}

bool DeviceLine::Poll(const link::ReliableLink::Handler& handler) {
  if (!link_) return false;
  if (!link_->Poll(handler)) link_.reset();
  if (!is_up() || link_->session() == session_) return false;
  session_ = link_->session();
  waiting_.clear();
  next_status_ = std::chrono::nanoseconds{0};
  return true;
}

void DeviceLine::Flush() {
  while (link_ && !waiting_.empty() && link_->CanSend()) {
    if (!link_->Send(waiting_.front().first, waiting_.front().second)) return;
    waiting_.pop_front();
  }
}

}  // namespace intaglio::virtual_engraver
