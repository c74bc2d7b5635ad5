// A deviation is that of a burnt place from the nearest place of the planned way: both
// are drawn, the deviation times the magnification. What is left open along the way keeps
// its size.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/render/text.h"
#include "engrave/render/web/mark_view_parts.h"

namespace intaglio::render {
namespace {

constexpr int kCloseUpTopPx = 44, kCloseUpEdgePx = 30;
constexpr double kCloseUpCapPx = 9.5, kCloseUpLinePx = 18;
constexpr double kCloseUpToleranceShare = 1.0 / 12, kCloseUpDeviationShare = 1.0 / 4;

Vec2 NearestOf(const ShownMark& mark, const Vec2& place_mm) {
  const std::vector<Vec2>& way_mm = mark.way_mm;
  Vec2 nearest = way_mm.front();
  double distance_mm = (place_mm - nearest).norm();
  for (std::size_t i = 1; i < way_mm.size(); ++i) {
    if (!mark.IsLitTo(i)) continue;
    const Vec2 way = way_mm[i] - way_mm[i - 1];
    const double square = way.squaredNorm();
    const double share =
        square > 0 ? std::clamp((place_mm - way_mm[i - 1]).dot(way) / square, 0.0, 1.0)
                   : 0;
    const Vec2 at = way_mm[i - 1] + share * way;
    if ((place_mm - at).norm() >= distance_mm) continue;
    distance_mm = (place_mm - at).norm();
    nearest = at;
  }
  return nearest;
}

Box3 BoxOfPlaces(const std::vector<Vec2>& places_mm) {
  Box3 box;
  for (const Vec2& p : places_mm) box.Extend(Vec3(p.x(), p.y(), 0));
  return box;
}

double ExtentOfWay(const ShownMark& mark) {
  const double extent_mm = BoxOfPlaces(mark.way_mm).size_mm().maxCoeff();
  return extent_mm > 0 ? extent_mm : 1;
}

}  // namespace

double CloseUpMagnification(const CloseUp& close_up, double tolerance_um) {
  const double extent_mm = ExtentOfWay(close_up.mark);
  double largest_mm = 0;
  for (const BurntStroke& stroke : close_up.burnt)
    largest_mm = std::max(largest_mm,
                          (stroke.to_mm - NearestOf(close_up.mark, stroke.to_mm)).norm());
  double limit = std::numeric_limits<double>::infinity();
  if (tolerance_um > 0) limit = 1e3 * kCloseUpToleranceShare * extent_mm / tolerance_um;
  if (largest_mm > 0)
    limit = std::min(limit, kCloseUpDeviationShare * extent_mm / largest_mm);
  return std::isfinite(limit) ? std::max(1.0, RoundBelow(limit)) : 1;
}

void DrawCloseUp(Canvas& canvas, const Rect& cell, const CloseUp& close_up,
                 double tolerance_um) {
  const Palette palette;
  const ShownMark& mark = close_up.mark;
  const double by = CloseUpMagnification(close_up, tolerance_um);
  DrawCell(canvas, cell, close_up.title, "");
  const int text_px = static_cast<int>(
      kCloseUpLinePx * static_cast<double>(close_up.lines.size() + 1) + 10);
  const Rect room{cell.x + kCloseUpEdgePx, cell.y + kCloseUpTopPx + kCloseUpEdgePx / 2,
                  cell.width - 2 * kCloseUpEdgePx,
                  cell.height - kCloseUpTopPx - kCloseUpEdgePx - text_px};
  const auto magnified_mm = [&](const Vec2& place_mm) -> Vec2 {
    const Vec2 nearest_mm = NearestOf(mark, place_mm);
    return nearest_mm + by * (place_mm - nearest_mm);
  };
  Box3 box = BoxOfPlaces(mark.way_mm);
  const double edge_mm = by * tolerance_um / 1e3;
  box = {box.min_mm - Vec3(edge_mm, edge_mm, 0), box.max_mm + Vec3(edge_mm, edge_mm, 0)};
  for (const BurntStroke& stroke : close_up.burnt) {
    const Vec2 at_mm = magnified_mm(stroke.to_mm);
    box.Extend(Vec3(at_mm.x(), at_mm.y(), 0));
  }
  const MarkScale scale = FitInto(room, box);
  DrawScaleBar(canvas, cell, scale.px_per_mm);
  const double band_px = 2 * edge_mm * scale.px_per_mm;
  const auto draw_way = [&](double width_px, const Color& color) {
    for (std::size_t i = 1; i < mark.way_mm.size(); ++i) {
      if (!mark.IsLitTo(i)) continue;
      DrawLine(canvas, scale(mark.way_mm[i - 1]), scale(mark.way_mm[i]), width_px,
               {color});
    }
  };
  if (band_px > 0) draw_way(band_px, Srgb(0x1B2E47));
  draw_way(1.2, palette.dim_text);
  const Color color =
      mark.state == MarkState::kMade ? palette.warning : ColorOf(mark.state);
  for (const BurntStroke& stroke : close_up.burnt)
    DrawLine(canvas, scale(magnified_mm(stroke.from_mm)),
             scale(magnified_mm(stroke.to_mm)), 2, {color});
  double y_px = cell.bottom() - text_px + 6.0;
  for (const std::string& line : close_up.lines) {
    const TextStyle style{.cap_height_px = kCloseUpCapPx, .color = palette.text};
    DrawText(canvas, {cell.x + 18.0, y_px}, line,
             FittingStyle(line, style, cell.width - 36.0));
    y_px += kCloseUpLinePx;
  }
  DrawText(canvas, {cell.x + 18.0, y_px},
           close_up.burnt.empty()
               ? std::string("grey: planned; nothing was burnt")
               : fmt::format("grey: planned, in the tolerance; deviations {} times",
                             ShortNumber(by)),
           {.cap_height_px = 9, .color = palette.dim_text});
}

}  // namespace intaglio::render
