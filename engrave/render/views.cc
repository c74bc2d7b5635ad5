#include "engrave/render/views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

// The perspective view on the left; on the right, in the order of a drawing (first
// angle), the front view, the view from the right beside it and the view from above below
// it, so that equal coordinates are aligned; the numbers in the fourth corner.

namespace intaglio::render {
namespace {

constexpr int kMarginPx = 24;
constexpr int kGapPx = 14;
constexpr int kHeaderPx = 96;
constexpr int kPerspectiveWidthPx = 810;

void DrawBackground(Canvas& canvas) {
  const Palette palette;
  for (int y = 0; y < canvas.height(); ++y) {
    const float t = static_cast<float>(y) / static_cast<float>(canvas.height());
    const Color color = Mix(palette.background_top, palette.background_bottom, t);
    for (int x = 0; x < canvas.width(); ++x) canvas.at(x, y) = color;
  }
}

/// The verdict in a frame of its colour, right-aligned; returns its left end.
double DrawVerdict(Canvas& canvas, const ViewsCaption& caption) {
  const double right_px = kViewsWidth - kMarginPx;
  if (caption.verdict.empty()) return right_px;
  const Palette palette;
  const Color& color = palette.of(caption.verdict_tone);
  const double cap_px = 16.0;
  const int width_px = static_cast<int>(TextWidth(caption.verdict, cap_px)) + 48;
  const Rect frame{kViewsWidth - kMarginPx - width_px, 28, width_px, 48};
  FillRect(canvas, frame, {color, 0.10F});
  FrameRect(canvas, frame, {color, 0.8F});
  DrawText(
      canvas, {frame.x + 0.5 * frame.width, frame.y + 0.5 * (frame.height + cap_px)},
      caption.verdict,
      {.cap_height_px = cap_px, .color = color, .weight = 1.3, .align = Align::kCenter});
  return frame.x;
}

void DrawTitle(Canvas& canvas, const ViewsCaption& caption, double right_px) {
  const Palette palette;
  constexpr std::array<double, 3> kBaselines = {44.0, 68.0, 87.0};
  const std::size_t count = std::min(caption.title_lines.size(), kBaselines.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& line = caption.title_lines[i];
    const double cap_px = i == 0 ? 20.0 : 10.5;
    const double room_px = right_px - 2.0 * kMarginPx;
    const double shrink = std::min(1.0, room_px / std::max(1.0, TextWidth(line, cap_px)));
    DrawText(canvas, {kMarginPx, kBaselines[i]}, line,
             {.cap_height_px = cap_px * shrink,
              .color = i == 0 ? palette.text : palette.dim_text,
              .weight = i == 0 ? 1.2 : 1.0});
  }
}

}  // namespace

void DrawPage(Canvas& canvas, const ViewsCaption& caption) {
  DrawBackground(canvas);
  DrawTitle(canvas, caption, DrawVerdict(canvas, caption));
}

PageCells CellsOfPage() {
  const int height = kViewsHeight - kHeaderPx - kGapPx - kMarginPx;
  const int top = kHeaderPx + kGapPx;
  const Rect large{kMarginPx, top, kPerspectiveWidthPx, height};
  const int left = large.right() + kGapPx;
  const int cell_width = (kViewsWidth - kMarginPx - left - kGapPx) / 2;
  const int cell_height = (height - kGapPx) / 2;
  const int column = left + cell_width + kGapPx;
  const int row = top + cell_height + kGapPx;
  return {large,
          {left, top, cell_width, cell_height},
          {column, top, cell_width, cell_height},
          {left, row, cell_width, cell_height},
          {column, row, cell_width, cell_height}};
}

void DrawCell(Canvas& canvas, const Rect& cell, const std::string& name,
              const std::string& words) {
  const Palette palette;
  FillRect(canvas, cell, {palette.cell, 0.55F});
  FrameRect(canvas, cell, {palette.cell_frame, 0.9F});
  const double cap_px = 11.0;
  const Vec2 at_px(cell.x + 18.0, cell.y + 26.0);
  DrawText(canvas, at_px, name,
           {.cap_height_px = cap_px, .color = palette.text, .weight = 1.25});
  DrawText(canvas, at_px + Vec2(TextWidth(name, cap_px) + 12.0, 0.0), words,
           {.cap_height_px = 9.5, .color = palette.dim_text});
}

std::string ShortNumber(double value) { return fmt::format("{:.6g}", value); }

Canvas RenderViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                   const ViewsCaption& caption) {
  Require((block_size_mm.array() > 0.0).all() && block_size_mm.allFinite(),
          "a block of {} x {} x {} mm", block_size_mm.x(), block_size_mm.y(),
          block_size_mm.z());
  Canvas canvas(kViewsWidth, kViewsHeight);
  DrawPage(canvas, caption);
  const auto [perspective, front, side, above, figures] = CellsOfPage();
  const double px_per_mm = std::min({FittingScale(front, kFromFront, block_size_mm),
                                     FittingScale(side, kFromRight, block_size_mm),
                                     FittingScale(above, kFromAbove, block_size_mm)});
  DrawPerspectiveView(canvas, perspective, cracks_mm, block_size_mm);
  DrawOrthographicView(canvas, front, kFromFront, px_per_mm, cracks_mm, block_size_mm);
  DrawOrthographicView(canvas, side, kFromRight, px_per_mm, cracks_mm, block_size_mm);
  DrawOrthographicView(canvas, above, kFromAbove, px_per_mm, cracks_mm, block_size_mm);
  DrawFiguresPanel(canvas, figures, caption.figures);
  return canvas;
}

}  // namespace intaglio::render
