#pragma once

// The errors of a place to which no axes lead, in one form.

#include <fmt/format.h>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::machine {

/// kOutsideBlock: "the focus at (x, y, z) mm of the machine frame WHY".
inline tl::unexpected<Error> Unreachable(const Vec3& place_mm, const std::string& why) {
  const std::string place =
      fmt::format("({:.6g}, {:.6g}, {:.6g})", place_mm.x(), place_mm.y(), place_mm.z());
  return Fail(ErrorCode::kOutsideBlock,
              fmt::format("the focus at {} mm of the machine frame {}", place, why),
              place);
}

inline tl::unexpected<Error> NoNumber(const Vec3& place_mm) {
  return Unreachable(place_mm, "is no place; correct the coordinate that is no number");
}

}  // namespace intaglio::machine
