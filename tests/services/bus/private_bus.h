#pragma once

// A bus that no other process sees, and waiting with an end, for tests of services.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "services/bus/bus.h"

namespace intaglio::test {

/// The same for all calls in one process; children get it by their command line.
inline std::string PrivateTag() { return fmt::format("test-{}", getpid()); }

inline bus::BusOptions PrivateBusOptions(const std::string& cell = {}) {
  bus::BusOptions options;
  options.tag = PrivateTag();
  options.cell = cell;
  return options;
}

/// Looks every 2 ms until the condition holds or the time is up; the last look counts.
/// Discovery between processes has no event of its own that could be waited for.
inline bool Eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds timeout = std::chrono::seconds(10)) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return condition();
}

}  // namespace intaglio::test
