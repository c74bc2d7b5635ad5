#pragma once

#include <cstdint>
#include <optional>

#include "services/platform/recording/mcap_reader.h"

namespace intaglio::cli {

/// Seconds after the beginning of the recording as log time, ns; beyond 1e9 s, also
/// infinity, nothing: after its end. No time is after the last one that there is.
inline std::optional<std::uint64_t> LogTimeAt(const recording::McapReader& reader,
                                              double seconds) {
  if (!(seconds < 1e9)) return std::nullopt;
  return reader.contents().statistics.start_ns +
         static_cast<std::uint64_t>(seconds * 1e9);
}

}  // namespace intaglio::cli
