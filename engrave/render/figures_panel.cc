#include <algorithm>
#include <cmath>

#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {

void DrawFiguresPanel(Canvas& canvas, const Rect& cell,
                      const std::vector<Figure>& figures) {
  const Palette palette;
  DrawCell(canvas, cell, "Figures", "");
  if (figures.empty()) return;
  const double top_px = cell.y + 52.0;
  const double room_px = cell.bottom() - 16.0 - top_px;
  const double row_px = std::min(34.0, room_px / static_cast<double>(figures.size()));
  const double cap_px = std::clamp(0.36 * row_px, 5.0, 11.0);
  const double left_px = cell.x + 20.0;
  const double right_px = cell.right() - 20.0;
  double row_top_px = top_px;
  for (const Figure& figure : figures) {
    const double baseline_px = row_top_px + 0.5 * (row_px + cap_px);
    const double label_px = TextWidth(figure.label, cap_px);
    DrawText(canvas, {left_px, baseline_px}, figure.label,
             {.cap_height_px = cap_px, .color = palette.dim_text});
    // A value too long for what is left of the row is set smaller, not cut.
    const double left_over_px = right_px - left_px - label_px - 16.0;
    const double value_px = TextWidth(figure.value, cap_px);
    const double shrink = value_px > left_over_px && left_over_px > 0.0
                              ? std::max(0.5, left_over_px / value_px)
                              : 1.0;
    DrawText(canvas, {right_px, baseline_px}, figure.value,
             {.cap_height_px = cap_px * shrink,
              .color = palette.of(figure.tone),
              .weight = 1.15,
              .align = Align::kRight});
    row_top_px += row_px;
    if (&figure == &figures.back()) break;
    const double line_px = std::floor(row_top_px) + 0.5;
    DrawLine(canvas, {left_px, line_px}, {right_px, line_px}, 1.0,
             {palette.cell_frame, 0.6F});
  }
}

}  // namespace intaglio::render
