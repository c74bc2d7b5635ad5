#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>

#include "engrave/core/result.h"
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

/// A bound of a span, as it was given.
struct SpanBound {
  const char* option;
  double seconds;
};

/// kInvalidValue: nothing of the recording can be between the two.
inline Status CheckSpan(const recording::McapReader& reader, const SpanBound& from,
                        const SpanBound& to) {
  const auto& statistics = reader.contents().statistics;
  const double length_s =
      static_cast<double>(statistics.end_ns - statistics.start_ns) * 1e-9;
  if (from.seconds > 0 && from.seconds > length_s) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} {:g}: {} ends {:.1f} s after its beginning", from.option,
                            from.seconds, reader.name(), length_s),
                fmt::format("{:g}", from.seconds));
  }
  if (to.seconds > from.seconds) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} {:g}: give more than {} {:g}", to.option, to.seconds,
                          from.option, from.seconds),
              fmt::format("{:g}", to.seconds));
}

}  // namespace intaglio::cli
