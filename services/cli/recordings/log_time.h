#pragma once

#include <cstdint>
#include <limits>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {

/// Seconds after the beginning of the recording as log time, ns; beyond 1e9 s, also
/// infinity: after its end.
inline std::uint64_t LogTimeAt(const recording::McapReader& reader, double seconds) {
  if (!(seconds < 1e9)) return std::numeric_limits<std::uint64_t>::max();
  return reader.contents().statistics.start_ns +
         static_cast<std::uint64_t>(seconds * 1e9);
}

}  // namespace intaglio::cli
