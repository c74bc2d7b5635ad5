#include "engrave/render/spacing_map.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "engrave/core/check.h"
#include "engrave/render/projection.h"
#include "engrave/render/spacing_view.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

struct Stop {
  double ratio;
  std::uint32_t rgb;
};
// Right is from the minimum spacing to a half more, as a blue-noise cloud has it; twice
// the spacing shows as a gap.
constexpr Stop kStops[] = {
    {1.0, 0x4FE08A}, {1.25, 0x3CD3B4}, {1.6, 0x3AA8F0}, {2.2, 0x3F63F2}, {3.0, 0x3A37B8}};
constexpr std::uint32_t kTooNearRgb = 0xFF4B3E;

/// The bins' place in their cell.
struct Axes {
  double left_px, right_px, top_px, bottom_px, span_mm;

  double x_px(double mm) const { return left_px + (right_px - left_px) * mm / span_mm; }
};

void DrawBars(Canvas& canvas, const Axes& axes, const SpacingMap& map) {
  std::uint64_t largest = 1;
  for (const std::uint64_t count : map.bins) largest = std::max(largest, count);
  for (std::size_t i = 0; i < map.bins.size(); ++i) {
    if (map.bins[i] == 0) continue;
    const double share = static_cast<double>(map.bins[i]) / static_cast<double>(largest);
    // A few points that are too near must be visible beside a million that are not.
    const double height_px = std::max(3.0, share * (axes.bottom_px - axes.top_px));
    const int left = static_cast<int>(axes.x_px(static_cast<double>(i) * map.bin_mm));
    const int right =
        static_cast<int>(axes.x_px(static_cast<double>(i + 1) * map.bin_mm));
    const int top = static_cast<int>(axes.bottom_px - height_px);
    const double ratio = (static_cast<double>(i) + 0.5) * map.bin_mm / map.min_spacing_mm;
    FillRect(canvas,
             {left, top, std::max(1, right - left - 1),
              static_cast<int>(axes.bottom_px) - top},
             {SpacingColor(ratio), 0.92F});
  }
}

void DrawAxis(Canvas& canvas, const Axes& axes, const SpacingMap& map) {
  const Palette palette;
  DrawLine(canvas, {axes.left_px, axes.bottom_px + 0.5},
           {axes.right_px, axes.bottom_px + 0.5}, 1.0, {palette.dim_text, 0.8F});
  const double step_mm = NiceStep(axes.span_mm, 6);
  TextStyle style{.cap_height_px = 9.0, .color = palette.dim_text};
  style.align = Align::kCenter;
  for (int i = 0; i * step_mm <= axes.span_mm * (1 + 1e-9); ++i) {
    const double x_px = std::floor(axes.x_px(i * step_mm)) + 0.5;
    DrawLine(canvas, {x_px, axes.bottom_px}, {x_px, axes.bottom_px + 5}, 1.0,
             {palette.dim_text});
    DrawText(canvas, {x_px, axes.bottom_px + 20}, ShortNumber(i * step_mm), style);
  }
  const double limit_px = std::floor(axes.x_px(map.min_spacing_mm)) + 0.5;
  DrawLine(canvas, {limit_px, axes.top_px - 8}, {limit_px, axes.bottom_px}, 1.0,
           {palette.text, 0.8F});
  style.color = palette.text;
  style.align = Align::kRight;
  DrawText(canvas, {limit_px - 6, axes.top_px},
           "minimum " + ShortNumber(map.min_spacing_mm) + " mm", style);
}

/// The legend of the colours: a strip with the same axis.
void DrawLegend(Canvas& canvas, const Axes& axes, const SpacingMap& map) {
  const Palette palette;
  const int top = static_cast<int>(axes.bottom_px) + 34;
  for (int x = static_cast<int>(axes.left_px); x < static_cast<int>(axes.right_px); ++x) {
    const double mm =
        (x + 0.5 - axes.left_px) / (axes.right_px - axes.left_px) * axes.span_mm;
    FillRect(canvas, {x, top, 1, 12}, {SpacingColor(mm / map.min_spacing_mm)});
  }
  TextStyle style{.cap_height_px = 9.0, .color = palette.dim_text};
  style.align = Align::kCenter;
  const double base_px = top + 30;
  const auto label = [&](double ratio, const char* text) {
    DrawText(canvas, {axes.x_px(ratio * map.min_spacing_mm), base_px}, text, style);
  };
  label(0.5, "too near");
  label(1.25, "right");
  label(2.5, "wide");
}

void DrawHistogram(Canvas& canvas, const Rect& cell, const SpacingMap& map) {
  DrawCell(canvas, cell, "Distances", "to the nearest point, mm");
  const Axes axes{cell.x + 28.0, cell.right() - 28.0, cell.y + 62.0, cell.bottom() - 92.0,
                  map.bin_mm * static_cast<double>(map.bins.size())};
  DrawBars(canvas, axes, map);
  DrawAxis(canvas, axes, map);
  DrawLegend(canvas, axes, map);
}

/// The points' extent; a flat cloud or a single point gets the extent of a few spacings.
Box3 Extent(const SpacingMap& map) {
  Box3 box;
  for (const Vec3& p : map.points_mm) box.Extend(p);
  const Vec3 smallest = Vec3::Constant(4 * map.min_spacing_mm);
  const Vec3 more = 0.5 * (smallest - box.size_mm()).cwiseMax(0.0);
  box.min_mm -= more;
  box.max_mm += more;
  return box;
}

struct MapCells {
  Rect front, right, above, histogram;
};

/// The view from the front is large; the other cells are one below the other beside it.
MapCells CellsIn(const Rect& room) {
  const int left = 11 * room.width / 20;
  const int x = room.x + left + kCellGapPx;
  const int width = room.right() - x;
  const int height = (room.height - 2 * kCellGapPx) / 3;
  const int step = height + kCellGapPx;
  return {{room.x, room.y, left, room.height},
          {x, room.y, width, height},
          {x, room.y + step, width, height},
          {x, room.y + 2 * step, width, room.bottom() - room.y - 2 * step}};
}

}  // namespace

Color SpacingColor(double ratio) {
  // Rounding of a lattice of exactly the minimum spacing is not a fault.
  if (ratio < 1 - 1e-8) return Srgb(kTooNearRgb);
  const Stop* stop = std::begin(kStops);
  while (stop + 1 != std::end(kStops) && stop[1].ratio <= ratio) ++stop;
  if (stop + 1 == std::end(kStops)) return Srgb(stop->rgb);
  const double t = (std::max(ratio, 1.0) - stop->ratio) / (stop[1].ratio - stop->ratio);
  return Mix(Srgb(stop->rgb), Srgb(stop[1].rgb), static_cast<float>(t));
}

Canvas RenderSpacingMap(const SpacingMap& map, const ViewsCaption& caption) {
  Require(!map.points_mm.empty() && map.nearest_mm.size() == map.points_mm.size(),
          "{} points with {} distances", map.points_mm.size(), map.nearest_mm.size());
  Require(map.min_spacing_mm > 0 && map.bin_mm > 0 && !map.bins.empty(),
          "a minimum spacing of {} mm, {} bins of {} mm", map.min_spacing_mm,
          map.bins.size(), map.bin_mm);
  Canvas canvas(kViewsWidth, kViewsHeight);
  const Page page = LayOutPage(caption);
  DrawPage(canvas, page);
  const MapCells cells = CellsIn(page.views);
  const Box3 box_mm = Extent(map);
  DrawSpacingView(canvas, cells.front, kFromFront,
                  FittingSpacingScale(cells.front, kFromFront, box_mm), box_mm, map);
  const double small_scale =
      std::min(FittingSpacingScale(cells.right, kFromRight, box_mm),
               FittingSpacingScale(cells.above, kFromAbove, box_mm));
  DrawSpacingView(canvas, cells.right, kFromRight, small_scale, box_mm, map);
  DrawSpacingView(canvas, cells.above, kFromAbove, small_scale, box_mm, map);
  DrawHistogram(canvas, cells.histogram, map);
  return canvas;
}

}  // namespace intaglio::render
