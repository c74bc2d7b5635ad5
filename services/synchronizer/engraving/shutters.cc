#include "services/synchronizer/engraving/shutters.h"

namespace intaglio::synchronizer {

using namespace std::chrono_literals;

namespace {
constexpr auto kCloseRequestPeriod = 20ms;  // that of the controller's status
}  // namespace

bool Shutters::Open(ChannelMask mask, std::chrono::nanoseconds now) {
  if (!laser_.CanSend() || !laser_.OpenShutters(mask)) return false;
  run_mask_ = mask;
  seen_open_ = false;
  opened_at_ = now;
  (void)laser_.RequestStatus();
  return true;
}

bool Shutters::KeepClosed(std::chrono::nanoseconds now) {
  if (laser_.status().shutters_open == 0) {
    closing_since_ = -1ns;
    return true;
  }
  if (closing_since_ < 0ns) closing_since_ = now;
  if (now >= next_close_ && laser_.CanSend()) {
    next_close_ = now + kCloseRequestPeriod;
    (void)laser_.OpenShutters(0);
    (void)laser_.RequestStatus();
  }
  return false;
}

}  // namespace intaglio::synchronizer
