#pragma once

// The parts of the picture of mark_views.h, and what they share.

#include "engrave/render/view_parts.h"
#include "engrave/render/web/mark_views.h"

namespace intaglio::render {

const Color& ColorOf(MarkState state);

/// 1, 2 or 5 times a power of ten, not above `limit` > 0.
double RoundBelow(double limit);

/// From millimetres to the pixels of a room, y up, the middles upon each other.
struct MarkScale {
  double px_per_mm = 1;
  Vec2 middle_mm = Vec2::Zero(), middle_px = Vec2::Zero();

  Vec2 operator()(const Vec2& mm) const {
    const Vec2 from_middle = px_per_mm * (mm - middle_mm);
    return {middle_px.x() + from_middle.x(), middle_px.y() - from_middle.y()};
  }
};
MarkScale FitInto(const Rect& room, const Box3& box_mm);

void DrawOverview(Canvas& canvas, const Rect& cell, const MarkViews& views);
void DrawErrors(Canvas& canvas, const Rect& cell, const MarkViews& views);
void DrawCloseUp(Canvas& canvas, const Rect& cell, const CloseUp& close_up,
                 double tolerance_um);

/// Height of the overview for what is shown, within these limits.
int OverviewHeight(const MarkViews& views, int width_px, int min_px, int max_px);

}  // namespace intaglio::render
