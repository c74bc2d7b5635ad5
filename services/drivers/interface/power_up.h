#pragma once

// The power-up of a controller that reports none: drawn at each connection, so that ticks
// and counters of an earlier one are never taken for those of this one.

#include <algorithm>
#include <cstdint>
#include <random>

namespace intaglio::drivers {

/// Not 0.
inline std::uint32_t DrawPowerUp() {
  std::random_device draw;
  return std::max<std::uint32_t>(1, draw());
}

}  // namespace intaglio::drivers
