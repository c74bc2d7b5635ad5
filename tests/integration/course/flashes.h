#pragma once

// The flashes of a virtual grbl's laser, as its program wrote them down (virtual-grbl
// --record): the judge of jobs of points. Frame: the machine's axes, mm.

#include <filesystem>

#include "engrave/core/geometry.h"

namespace intaglio::testing {

struct FlashRecord {
  PointList began_mm;         ///< the true place at which each flash began
  double lit_at_rest_us = 0;  ///< of all of them
};

FlashRecord ReadFlashes(const std::filesystem::path& file);

/// Height of the axis for each point: glass refracts, so it goes linearly with the
/// point's own height.
struct HeightFit {
  double slope = 1, offset_mm = 0;
  Vec3 AxesAt(const Vec3& point_mm) const {
    return {point_mm.x(), point_mm.y(), slope * point_mm.z() + offset_mm};
  }
};

/// Fitted on the flashes whose x and y have one point alone.
HeightFit FitHeight(const PointList& points_mm, const PointList& flashes_mm);

}  // namespace intaglio::testing
