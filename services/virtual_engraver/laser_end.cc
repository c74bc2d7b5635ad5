#include "services/virtual_engraver/laser_end.h"

namespace intaglio::virtual_engraver {

using link::LaserFrame;

bool LaserEnd::Poll(const link::ReliableLink::Handler& also) {
  // The identity goes first in a session, before what its frames are answered with.
  if (!line_.Poll([&](std::uint8_t type, std::span<const std::byte> payload) {
        Obey(static_cast<LaserFrame>(type), payload);
        if (also) also(type, payload);
      })) {
    return false;
  }
  laser_.NewSession();
  line_.Send(LaserFrame::kLaserIdentity, Encode(laser_.Identity()));
  sent_accessories_ = {};
  SendAccessories();
  return true;
}

void LaserEnd::Obey(LaserFrame type, std::span<const std::byte> payload) {
  if (laser_.Obey(type, payload)) return;
  switch (type) {
    case LaserFrame::kLaserStatusRequest:
      line_.AskForStatus();
      return;
    case LaserFrame::kPastRequest:
      if (const auto m = link::Decode<link::PastRequest>(payload))
        line_.Send(LaserFrame::kPastReport, Encode(laser_.Past(*m)));
      return;
    default:
      return;  // a frame of the stage, or of another version of the protocol
  }
}

// A controller that has none differs from nothing, and sends none.
void LaserEnd::SendAccessories() {
  if (laser_.accessories() == sent_accessories_ || !line_.is_up()) return;
  sent_accessories_ = laser_.accessories();
  line_.Send(LaserFrame::kAccessoryState, Encode(sent_accessories_));
}

void LaserEnd::SendOutcomes() {
  SendAccessories();
  for (const link::PulseReport& report : laser_.TakeReports())
    line_.Send(LaserFrame::kPulseReport, Encode(report));
}

void LaserEnd::SendStatus(std::chrono::nanoseconds now, bool at_once,
                          std::chrono::nanoseconds period) {
  const link::LaserStatus status = laser_.Report();
  const std::uint32_t interlocks = status.interlocks | status.shutters_open << 8;
  if (!at_once && interlocks == sent_interlocks_ && !line_.IsStatusDue(now)) return;
  sent_interlocks_ = interlocks;
  line_.SetNextStatus(now + period);
  if (line_.is_up()) line_.Send(LaserFrame::kLaserStatus, Encode(status));
}

}  // namespace intaglio::virtual_engraver
