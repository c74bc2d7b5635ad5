#pragma once

// How long work in hand takes yet (services/client/shop/work_left.h), as people read it:
// the same for the bar of `run` and `watch` and for the lines of `list`, `show` and
// `status`.

#include <cstdint>
#include <ctime>
#include <string>

#include "services/client/shop/work_left.h"

namespace intaglio::cli {

/// "14:32", or "2026-11-29 01:05" of another day than `now`; of this computer's time
/// zone.
std::string ClockTime(std::time_t time, std::time_t now);

struct TimeLeft {
  std::string left;  ///< "7 min 02 s left"; empty: not known
  std::string
      ends;  ///< from a minute on "ends 14:32", by this computer's clock; else empty
};

TimeLeft TimeLeftOf(const client::WorkLeft& work, std::time_t now);

/// With the share: "52 %, 7 min 02 s left, ends 14:32"; empty where it is not known.
std::string TimeLeftText(const client::WorkLeft& work, std::time_t now);

/// The time left of a job at work and the speed that was set: "52 %, 7 min 02 s left,
/// ends 14:32, at 50 % speed"; empty where there is neither.
std::string PaceText(const client::WorkLeft& work, std::uint32_t speed_percent,
                     std::time_t now);

}  // namespace intaglio::cli
