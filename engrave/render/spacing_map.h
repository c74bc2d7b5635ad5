#pragma once

// A map of the spacing of the points of a cloud: three parallel views of the side that is
// turned to the viewer, each point in the colour of its distance to the nearest other
// one, and the histogram of these distances. Red: nearer than the minimum spacing, and
// shown even where other points hide it; green: right; blue: wide.

#include <cstdint>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/views.h"

namespace intaglio::render {

struct SpacingMap {
  const PointList& points_mm;          ///< glass frame, finite, one or more
  std::span<const double> nearest_mm;  ///< of each point; infinite when it is alone
  double min_spacing_mm = 0;           ///< positive
  /// Histogram of nearest_mm, from 0 on; the last bin holds all that is wider.
  double bin_mm = 0;
  std::span<const std::uint64_t> bins;
};

/// The colour of a distance by its ratio to the minimum spacing.
Color SpacingColor(double ratio);

/// kViewsWidth x kViewsHeight pixels; the same input gives the same picture. Takes about
/// a second for a million points.
Canvas RenderSpacingMap(const SpacingMap& map, const ViewsCaption& caption);

}  // namespace intaglio::render
