#include "engrave/render/web/mark_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engrave/render/page.h"
#include "engrave/render/text.h"
#include "engrave/render/web/mark_view_parts.h"

namespace intaglio::render {
namespace {

constexpr int kErrorsPx = 170, kMinCloseUpPx = 300, kMinOverviewPx = 220;
constexpr int kErrorsTopPx = 44, kErrorsSidePx = 74;

/// The largest error of the marks of one column of pixels.
struct ErrorColumn {
  double error_um = 0;
  MarkState state = MarkState::kMade;
  bool any = false;
};

std::vector<ErrorColumn> ColumnsOf(const std::vector<MarkError>& errors, int count) {
  std::vector<ErrorColumn> columns(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < errors.size(); ++i) {
    ErrorColumn& column = columns[i * static_cast<std::size_t>(count) /
                                  std::max<std::size_t>(1, errors.size())];
    column.any = true;
    column.error_um = std::max(column.error_um, errors[i].error_um);
    if (errors[i].state != MarkState::kMade) column.state = errors[i].state;
  }
  return columns;
}

}  // namespace

void DrawErrors(Canvas& canvas, const Rect& cell, const MarkViews& views) {
  const Palette palette;
  DrawCell(canvas, cell, "Errors",
           "largest of place, shape, gap and diameter of each mark, in the order of "
           "marking");
  const Rect room{cell.x + kErrorsSidePx, cell.y + kErrorsTopPx,
                  cell.width - kErrorsSidePx - 26, cell.height - kErrorsTopPx - 26};
  double top_um = 1.25 * views.tolerance_um;
  for (const MarkError& error : views.errors) top_um = std::max(top_um, error.error_um);
  if (top_um <= 0) top_um = 1;
  const auto y_of = [&](double um) { return room.bottom() - um / top_um * room.height; };
  const auto count = static_cast<int>(views.errors.size());
  const int columns = std::clamp(count, 1, room.width);
  const double step_px = static_cast<double>(room.width) / columns;
  const auto found = ColumnsOf(views.errors, columns);
  for (int i = 0; i < columns; ++i) {
    const ErrorColumn& column = found[static_cast<std::size_t>(i)];
    const double x_px = room.x + (i + 0.5) * step_px;
    const double width_px = std::clamp(0.7 * step_px, 1.0, 8.0);
    const bool beyond = column.error_um > views.tolerance_um;
    if (column.error_um > 0)
      DrawLine(canvas, {x_px, static_cast<double>(room.bottom())},
               {x_px, y_of(column.error_um)}, width_px,
               {beyond ? palette.bad : palette.good});
    if (column.state != MarkState::kMade)
      DrawLine(canvas, {x_px, static_cast<double>(room.bottom())},
               {x_px, static_cast<double>(room.y)}, std::max(2.0, width_px),
               {ColorOf(column.state)});
  }
  const auto level = [&](double um, const Color& color, const std::string& text) {
    DrawLine(canvas, {static_cast<double>(room.x), y_of(um)},
             {static_cast<double>(room.right()), y_of(um)}, 1.2, {color, 0.9F});
    DrawText(canvas, {room.x - 8.0, y_of(um) + 4}, text,
             {.cap_height_px = 9, .color = color, .align = Align::kRight});
  };
  level(0, palette.dim_text, "0");
  level(views.tolerance_um, palette.warning, fmt::format("{:g} µm", views.tolerance_um));
  DrawText(canvas, {static_cast<double>(room.x), room.bottom() + 17.0}, "mark 1",
           {.cap_height_px = 9, .color = palette.dim_text});
  DrawText(canvas, {static_cast<double>(room.right()), room.bottom() + 17.0},
           fmt::format("mark {}", count),
           {.cap_height_px = 9, .color = palette.dim_text, .align = Align::kRight});
}

Canvas DrawMarkViews(const MarkViews& views) {
  Canvas canvas(kViewsWidth, kViewsHeight);
  const Page page = LayOutPage(views.caption);
  DrawPage(canvas, page);
  const Rect& all = page.views;
  const bool measured = !views.errors.empty();
  const std::size_t close_ups = std::min(views.close_ups.size(), kMaxCloseUps);
  int below = 0;
  if (measured) below += kErrorsPx + kCellGapPx;
  if (close_ups > 0) below += kMinCloseUpPx + kCellGapPx;
  const int height =
      below == 0 ? all.height
                 : OverviewHeight(views, all.width, kMinOverviewPx, all.height - below);
  DrawOverview(canvas, {all.x, all.y, all.width, height}, views);
  int y = all.y + height + kCellGapPx;
  if (measured) {
    const int rest = all.bottom() - y;
    const int errors = close_ups > 0 ? kErrorsPx : rest;
    DrawErrors(canvas, {all.x, y, all.width, errors}, views);
    y += errors + kCellGapPx;
  }
  if (close_ups == 0) return canvas;
  const auto count = static_cast<int>(close_ups);
  const int width = (all.width - (count - 1) * kCellGapPx) / count;
  for (int i = 0; i < count; ++i)
    DrawCloseUp(canvas, {all.x + i * (width + kCellGapPx), y, width, all.bottom() - y},
                views.close_ups[static_cast<std::size_t>(i)], views.tolerance_um);
  return canvas;
}

}  // namespace intaglio::render
