#include "services/synchronizer/pulses/tick_clock.h"

#include <algorithm>

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

// A status is late by some milliseconds, now more, now less: over a second or two that is
// less than a per cent of the rate.
constexpr auto kShortestSpan = 50ms;
constexpr auto kLongestSpan = 2s;

double Seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

void TickClock::Observe(const link::LaserStatus& status, std::chrono::nanoseconds now) {
  const Sighting sighting{status.tick, now};
  if (status.rate_hz != rate_hz_ || status.tick < newest_.tick) {
    rate_hz_ = ticks_per_s_ = status.rate_hz;
    base_ = next_base_ = sighting;
    settled_ = false;
  }
  newest_ = sighting;
  if (now - next_base_.at > kLongestSpan / 2) {
    base_ = next_base_;
    next_base_ = sighting;
  }
  const auto span = now - base_.at;
  if (span < kShortestSpan) return;
  settled_ = true;
  ticks_per_s_ = static_cast<double>(newest_.tick - base_.tick) / Seconds(span);
}

std::uint64_t TickClock::TickAt(std::chrono::nanoseconds now) const {
  const double age_s = std::max(0.0, Seconds(now - newest_.at));
  return newest_.tick + static_cast<std::uint64_t>(age_s * ticks_per_s_);
}

}  // namespace intaglio::synchronizer
