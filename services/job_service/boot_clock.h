#pragma once

// Time since the machine was switched on. Unlike the steady clock it goes on while the
// machine sleeps, so an absence is never taken for a shorter one.

#include <time.h>

#include <chrono>

namespace intaglio::job_service {

inline std::chrono::nanoseconds SinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace intaglio::job_service
