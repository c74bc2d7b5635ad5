#pragma once

// Monotonic time of this computer, ns since an unspecified moment. Tests inject their
// own.

#include <chrono>
#include <functional>

namespace intaglio::link {

using SteadyClock = std::function<std::chrono::nanoseconds()>;

inline SteadyClock MonotonicClock() {
  return [] { return std::chrono::steady_clock::now().time_since_epoch(); };
}

}  // namespace intaglio::link
