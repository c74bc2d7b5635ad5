#pragma once

// Cracks as light: every point adds to the picture, and the sum is tone-mapped so that
// 1000 points are as visible as 1000000.

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/projection.h"

namespace intaglio::render {

struct CloudStyle {
  /// How large the dots may get where points are far apart: the standard deviation of
  /// their light. Where points are nearer, dots are smaller, so that they remain
  /// distinct.
  float max_sigma_px = 1.5F;
  /// Work in one plane has no form to be shaded: its layers would darken one another.
  bool is_flat = false;
};

/// Adds the cloud (frame glass, mm) to the window of the canvas. Points of the side
/// turned to the viewer outshine those behind them, and the relief of that side is
/// shaded, so that a form can be read where a mere sum of light would be a silhouette.
void DrawCloud(Canvas& canvas, const Rect& window, const Projection& projection,
               const PointList& points_mm, const CloudStyle& style = {});

}  // namespace intaglio::render
