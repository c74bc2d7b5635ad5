#pragma once

// The counts of a job's points or marks, in the messages that name them alike.

#include <algorithm>
#include <cstdint>
#include <limits>

#include "services/client/job_view.h"

namespace intaglio::client {

/// A count as the messages have it; what is larger is the largest.
inline std::uint32_t ShownCount(std::uint64_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

template <typename Message>
void SetCounts(const intaglio_PointCounts& counts, Message& message) {
  message.set_planned(ShownCount(counts.planned));
  message.set_made(ShownCount(counts.made));
  message.set_missed(ShownCount(counts.missed));
  message.set_skipped(ShownCount(counts.skipped));
  message.set_uncertain(ShownCount(counts.uncertain));
  message.set_to_come(ShownCount(counts.to_come));
  message.set_armed_count(ShownCount(counts.armed));
}

}  // namespace intaglio::client
