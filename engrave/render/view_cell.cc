#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/render/projection.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {

void DrawCell(Canvas& canvas, const Rect& cell, const std::string& name,
              const std::string& description) {
  const Palette palette;
  FillRect(canvas, cell, {palette.cell, 0.55F});
  FrameRect(canvas, cell, {palette.cell_frame, 0.9F});
  const double cap_px = 11.0;
  const Vec2 at_px(cell.x + 18.0, cell.y + 26.0);
  DrawText(canvas, at_px, name,
           {.cap_height_px = cap_px, .color = palette.text, .weight = 1.25});
  DrawText(canvas, at_px + Vec2(TextWidth(name, cap_px) + 12.0, 0.0), description,
           {.cap_height_px = 9.5, .color = palette.dim_text});
}

void DrawScaleBar(Canvas& canvas, const Rect& cell, double px_per_mm) {
  const Palette palette;
  // In a narrow cell it must not reach the heading.
  const double shortest_px = std::min(90.0, 0.12 * cell.width);
  const double length_mm = NiceStep(shortest_px / px_per_mm, 1);
  const double right_px = cell.right() - 18.5;
  const double left_px = std::round(right_px - length_mm * px_per_mm);
  const double y_px = cell.y + 21.5;
  DrawLine(canvas, {left_px, y_px}, {right_px, y_px}, 2.0, {palette.text, 0.85F});
  for (const double x_px : {left_px, right_px}) {
    DrawLine(canvas, {x_px, y_px - 4}, {x_px, y_px + 4}, 1.5, {palette.text, 0.85F});
  }
  DrawText(canvas, {left_px - 10, y_px + 4.5}, ShortNumber(length_mm) + " mm",
           {.cap_height_px = 9.0, .color = palette.dim_text, .align = Align::kRight});
}

std::string StatusOf(const Panel& panel) {
  const bool parallel = panel.kind != PanelKind::kPerspective;
  return fmt::format("grid {} mm, {}{:.3g} pixels a mm", ShortNumber(GridStepOf(panel)),
                     parallel ? "" : "about ",
                     parallel ? panel.px_per_mm : MiddleScale(panel));
}

void DrawStatus(Canvas& canvas, const Panel& panel) {
  DrawText(canvas, Vec2(panel.cell.right() - 14.0, panel.cell.bottom() - 10.0),
           StatusOf(panel),
           {.cap_height_px = 8.0, .color = Palette().dim_text, .align = Align::kRight});
}

std::string SizeNumbers(const std::vector<double>& sizes_mm) {
  std::string text;
  for (const double size_mm : sizes_mm) {
    text += fmt::format("{}{:.4g}", text.empty() ? "" : " x ", size_mm);
  }
  return text + " mm";
}

std::string ShortNumber(double value) { return fmt::format("{:.6g}", value); }

}  // namespace intaglio::render
