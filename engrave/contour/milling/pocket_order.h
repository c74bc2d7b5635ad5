#pragma once

// The order of a pocket's paths. Each is made behind the deeper ones that it lies beside,
// so that the tool always cuts from what is cleared towards the wall. Where a pocket has
// islands or bays, passes of several walls are parts that do not touch: each is followed
// to its wall before the tool goes to another one. Frame: drawing, mm.

#include <cstdint>
#include <vector>

#include "engrave/contour/milling/pocket.h"

namespace intaglio::contour {

struct PocketStep {
  Edges path;              ///< closed, from where the tool comes down on it
  std::uint32_t pass = 0;  ///< of the pocket
};

/// All paths of the pocket, each once. From a path the tool goes on to the nearest one
/// beside it that is nearer to the wall, where all deeper ones beside that are made; else
/// to the nearest of all such paths. It comes down at the nearest place of the path.
std::vector<PocketStep> OrderPocket(const Pocket& pocket, const Vec2& start_mm);

}  // namespace intaglio::contour
