#pragma once

// One view of the spacing map (spacing_map.h).

#include "engrave/render/canvas.h"
#include "engrave/render/spacing_map.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {

/// Pixels per mm at which the cloud's extent fits the cell.
double FittingSpacingScale(const Rect& cell, const OrthographicView& view,
                           const Box3& box_mm);

/// `box_mm` holds the points. Axes and numbers are those of the glass.
void DrawSpacingView(Canvas& canvas, const Rect& cell, const OrthographicView& view,
                     double px_per_mm, const Box3& box_mm, const SpacingMap& map);

}  // namespace intaglio::render
