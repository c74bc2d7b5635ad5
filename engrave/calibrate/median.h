#pragma once

// Robust measures of a sample.

#include <algorithm>
#include <vector>

namespace intaglio::calibrate {

/// The upper of the two in the middle; `values` is not empty and is reordered.
template <typename T>
T MedianOf(std::vector<T>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Times the median of the absolute deviations it is the standard deviation of a normal
/// distribution.
inline constexpr double kNormalMad = 1.4826;

}  // namespace intaglio::calibrate
