#pragma once

// The ranges of options, in one sentence for all.

#include <fmt/format.h>

#include "engrave/core/result.h"

namespace intaglio::contour {

/// kInvalidValue unless `value` is in min .. max (not a number is in none): "the lead is
/// 0, it has to be 0.01 .. 1000; correct it". `name` is how a person calls the option.
inline Status CheckOption(const char* name, double value, double min, double max) {
  if (value >= min && value <= max) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("{} is {}, it has to be {} .. {}; correct it", name, value, min, max),
      fmt::format("{}", value));
}

}  // namespace intaglio::contour
