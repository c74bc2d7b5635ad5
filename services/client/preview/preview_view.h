#pragma once

// The points of a preview that turn in a browser: a part of the page that needs no
// network and no library.

#include <string>

#include "engrave/core/geometry.h"

namespace intaglio::client {

/// The page has at most so many points: every k-th of a larger cloud.
inline constexpr std::size_t kShownPoints = 40'000;

/// A canvas with its script: points in the frame glass, mm, in the block
/// 0..block_size_mm (each side > 0), each coordinate in 65536 steps of the block's side.
/// Pointer, wheel and arrow keys turn and enlarge it. Empty without points.
std::string TurningView(const PointList& points_mm, const Vec3& block_size_mm);

}  // namespace intaglio::client
