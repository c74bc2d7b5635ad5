#include "services/cli/sheet/sheet_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/render/text.h"

namespace intaglio::cli {
namespace {

using render::Canvas;
using render::Srgb;

constexpr std::size_t kMaxSheets = 100;
constexpr int kWidth = 1400, kGap = 40, kCaption = 44, kRest = 50;
constexpr double kMinSheetPx = 120;
constexpr double kChordPx = 2;  // of arcs
constexpr double kDashPx = 6;
constexpr std::uint32_t kPaper = 0x10141a, kSheet = 0x232a35, kPart = 0xe8c9a0,
                        kLine = 0x8a94a3, kLetters = 0xd8dee8;

/// Where the sheets lie, each below and to the right of the ones before it.
struct Layout {
  std::size_t columns = 1, rows = 1;
  double px_per_mm = 1;
  Vec2 sheet_px = Vec2::Ones();

  int height() const {
    return kGap + static_cast<int>(static_cast<double>(rows) * (sheet_px.y() + kCaption));
  }
  Vec2 LowerLeft(std::size_t sheet) const {
    const auto column = static_cast<double>(sheet % columns);
    const auto row = static_cast<double>(sheet / columns);
    return {kGap + column * (sheet_px.x() + kGap),
            kGap + row * (sheet_px.y() + kCaption) + sheet_px.y()};
  }
};

/// As large as all sheets together are not much higher than wide.
Layout LayoutOf(std::size_t sheets, const Vec2& sheet_mm) {
  Layout layout;
  for (layout.columns = 1;; ++layout.columns) {
    layout.rows = (sheets + layout.columns - 1) / layout.columns;
    const double width_px = (kWidth - kGap) / static_cast<double>(layout.columns) - kGap;
    layout.px_per_mm = std::min(width_px / sheet_mm.x(), kWidth / sheet_mm.y());
    layout.sheet_px = layout.px_per_mm * sheet_mm;
    if (layout.height() <= kWidth || layout.columns >= sheets || width_px < kMinSheetPx)
      return layout;
  }
}

/// Chords of a loop, px, y down.
std::vector<Vec2> ChordsOf(const contour::Edges& loop, const Vec2& lower_left_px,
                           double px_per_mm) {
  std::vector<Vec2> chords;
  for (const contour::Edge& edge : loop) {
    const int count =
        edge.is_arc()
            ? std::max(4, static_cast<int>(edge.length_mm * px_per_mm / kChordPx))
            : 1;
    for (int k = 0; k < count; ++k) {
      const Vec2 mm = contour::PointAt(edge, edge.length_mm * k / count);
      chords.emplace_back(lower_left_px.x() + px_per_mm * mm.x(),
                          lower_left_px.y() - px_per_mm * mm.y());
    }
  }
  return chords;
}

void DrawPart(const contour::Region& part, const Vec2& lower_left_px, double px_per_mm,
              Canvas& canvas) {
  std::vector<std::vector<Vec2>> loops;
  for (const contour::Edges& loop : part.loops)
    loops.push_back(ChordsOf(loop, lower_left_px, px_per_mm));
  render::FillLoops(canvas, loops, {Srgb(kPart)});
  for (const std::vector<Vec2>& loop : loops) {
    for (std::size_t k = 0; k < loop.size(); ++k)
      DrawLine(canvas, loop[k], loop[(k + 1) % loop.size()], 1, {Srgb(kPaper)});
  }
}

void DrawDashed(Canvas& canvas, const Vec2& from, const Vec2& to) {
  const double length = (to - from).norm();
  for (double at = 0; at < length; at += 2 * kDashPx) {
    const double end = std::min(length, at + kDashPx);
    DrawLine(canvas, from + at / length * (to - from), from + end / length * (to - from),
             1, {Srgb(kLine)});
  }
}

void DrawMargin(const Vec2& lower_left, const Vec2& size, double margin_px,
                Canvas& canvas) {
  const double left = lower_left.x() + margin_px, low = lower_left.y() - margin_px;
  const double right = left + size.x() - 2 * margin_px;
  const double top = low - size.y() + 2 * margin_px;
  if (margin_px < 2 || right <= left || top >= low) return;
  const std::array<Vec2, 4> corners = {Vec2(left, low), Vec2(right, low),
                                       Vec2(right, top), Vec2(left, top)};
  for (std::size_t k = 0; k < 4; ++k)
    DrawDashed(canvas, corners[k], corners[(k + 1) % 4]);
}

double UsePercent(const SheetDrawing& sheet, const Vec2& sheet_mm) {
  double used_mm2 = 0;
  for (const contour::Region& part : sheet.parts) used_mm2 += contour::AreaOf(part);
  return 100 * used_mm2 / (sheet_mm.x() * sheet_mm.y());
}

}  // namespace

Canvas DrawSheets(const std::vector<SheetDrawing>& sheets, const Vec2& sheet_mm,
                  double margin_mm) {
  Require(!sheets.empty(), "a picture of no sheet");
  const std::size_t drawn = std::min(sheets.size(), kMaxSheets);
  const Layout layout = LayoutOf(drawn, sheet_mm);
  Canvas canvas(kWidth, layout.height() + (drawn < sheets.size() ? kRest : 0));
  FillRect(canvas, {0, 0, canvas.width(), canvas.height()}, {Srgb(kPaper)});
  for (std::size_t k = 0; k < drawn; ++k) {
    const Vec2 at = layout.LowerLeft(k);
    const render::Rect rect{
        static_cast<int>(at.x()), static_cast<int>(at.y() - layout.sheet_px.y()),
        static_cast<int>(layout.sheet_px.x()), static_cast<int>(layout.sheet_px.y())};
    FillRect(canvas, rect, {Srgb(kSheet)});
    FrameRect(canvas, rect, {Srgb(kLine)});
    DrawMargin(at, layout.sheet_px, margin_mm * layout.px_per_mm, canvas);
    for (const contour::Region& part : sheets[k].parts)
      DrawPart(part, at, layout.px_per_mm, canvas);
    const std::string caption = fmt::format("sheet {}: {}, {:.1f} % used", k + 1,
                                            Counted(sheets[k].parts.size(), "part"),
                                            UsePercent(sheets[k], sheet_mm));
    DrawText(canvas, {at.x(), at.y() + 24}, caption,
             render::FittingStyle(caption, {10, Srgb(kLetters)}, layout.sheet_px.x()));
  }
  if (drawn < sheets.size()) {
    DrawText(canvas, {kGap, canvas.height() - kGap / 2.0},
             fmt::format("and {} more", Counted(sheets.size() - drawn, "sheet")),
             {10, Srgb(kLetters)});
  }
  return canvas;
}

}  // namespace intaglio::cli
