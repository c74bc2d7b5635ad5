#pragma once

// Cracks as light: every point adds to the picture, and the sum is tone-mapped so that
// 1000 points are as visible as 1000000.

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/projection.h"

namespace intaglio::render {

/// Adds the cloud (frame glass, mm) to the window of the canvas. Points of the side
/// turned to the viewer outshine those behind them, and the relief of that side is
/// shaded, so that a form can be read where a mere sum of light would be a silhouette.
void DrawCloud(Canvas& canvas, const Rect& window, const Projection& projection,
               const PointList& points_mm);

}  // namespace intaglio::render
