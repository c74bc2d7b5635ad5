#pragma once

// How the repeats of a run begin at the print marks of its web (MarkWeb.eye).

#include <cmath>
#include <cstdint>

namespace intaglio::drivers {

struct PrintEye {
  double pitch_mm = 1;      ///< between print marks, > 0; a mark's web_mm is a multiple
  double offset_mm = 0;     ///< x of a repeat's origin less that of its print mark
  double tolerance_mm = 0;  ///< of an expected place, 0..pitch / 2
  std::uint32_t max_missing = 0;   ///< in a row
  std::uint32_t first_repeat = 0;  ///< lowest of the run
};

/// Of a mark's web_mm, from 0.
inline std::uint32_t RepeatOf(double web_mm, double pitch_mm) {
  return static_cast<std::uint32_t>(std::llround(web_mm / pitch_mm));
}

}  // namespace intaglio::drivers
