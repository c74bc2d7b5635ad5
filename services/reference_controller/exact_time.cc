#include "services/reference_controller/exact_time.h"

#include <time.h>

#include <chrono>

namespace intaglio::reference_controller {

void TurnWait::WaitFor(std::chrono::nanoseconds idle) {
  constexpr std::chrono::nanoseconds kEvery{1'000'000};
  constexpr timespec kSleep{0, 60'000};
  const auto now = time_.clock();
  if (now - slept_at_ < kEvery) return time_.wait_until(now + idle);
  slept_at_ = now;
  (void)clock_nanosleep(CLOCK_MONOTONIC, 0, &kSleep, nullptr);
}

// A sleep ends late by the latency of the system's timers, 50 us where it is good.
ControllerTime ExactTime() {
  const link::SteadyClock clock = link::MonotonicClock();
  return {clock, [clock](std::chrono::nanoseconds until) {
            constexpr std::chrono::nanoseconds kEarly{100'000}, kSecond{1'000'000'000};
            const auto wake = until - kEarly;
            if (wake > clock()) {
              const timespec at{wake / kSecond, (wake % kSecond).count()};
              (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
            }
            while (clock() < until) {
            }
          }};
}

}  // namespace intaglio::reference_controller
