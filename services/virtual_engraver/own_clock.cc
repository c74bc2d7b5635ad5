#include "services/virtual_engraver/own_clock.h"

#include <algorithm>

namespace intaglio::virtual_engraver {
namespace {
// The stage's controller is switched on a while before the laser's.
constexpr double kEarlierNs = 1.7e9;
}  // namespace

OwnClock::OwnClock(const OwnClockOptions& options)
    : drift_ppm_(options.drift_ppm),
      jitter_ns_(1e9 * options.receive_jitter_s),
      power_up_(options.power_up),
      random_(options.seed),
      now_ns_(kEarlierNs) {}

std::uint64_t OwnClock::NsAfter(double seconds) const {
  return static_cast<std::uint64_t>(now_ns_ + 1e9 * seconds * (1 + 1e-6 * drift_ppm_));
}

void OwnClock::Advance(double seconds) {
  now_ns_ += 1e9 * seconds * (1 + 1e-6 * drift_ppm_);
}

void OwnClock::ReceiveTick(std::uint64_t tick) {
  // std::uniform_real_distribution may differ between libraries; this does not.
  const double ratio = static_cast<double>(random_() >> 11) * 0x1p-53;
  const auto due_ns = static_cast<std::uint64_t>(now_ns_ + ratio * jitter_ns_);
  received_by_ns_ = std::max(received_by_ns_, due_ns);
  underway_.push_back({tick, received_by_ns_});
}

std::optional<OwnClock::Received> OwnClock::ReceivesBy(std::uint64_t ns) {
  if (underway_.empty() || underway_.front().at_ns > ns) return std::nullopt;
  const Received received = underway_.front();
  underway_.pop_front();
  return received;
}

}  // namespace intaglio::virtual_engraver
