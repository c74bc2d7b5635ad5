#pragma once

// What the checks of both conformance suites share: a violation is thrown, so that a
// test can see that a check finds a fault.

#include <chrono>
#include <stdexcept>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::drivers {

using std::chrono::milliseconds;

// Reports come every 20 ms, and a frame takes a turn or two.
inline constexpr milliseconds kReportTime{30};
inline constexpr milliseconds kSilence{250};

inline void Expect(bool holds, const std::string& violation) {
  if (!holds) throw std::runtime_error(violation);
}

inline void Expect(const Status& status, const std::string& command) {
  Expect(status.has_value(),
         command + " is refused: " + (status ? "" : status.error().message));
}

}  // namespace intaglio::drivers
