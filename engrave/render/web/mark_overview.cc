#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "engrave/render/text.h"
#include "engrave/render/web/mark_view_parts.h"

namespace intaglio::render {
namespace {

constexpr int kOverviewTopPx = 44, kOverviewMarginPx = 26, kKeyPx = 30;
constexpr double kLongestArrowPx = 60;
constexpr double kArrowCellPx = 34;  // of several, the longest is drawn
constexpr std::size_t kMaxRings = 200;
constexpr double kNoticedMm = 1e-4;  // offsets of rounding alone stay short

Box3 ExtentOfViews(const MarkViews& views) {
  Box3 box;
  for (const ShownMark& mark : views.marks)
    for (const Vec2& p : mark.way_mm) box.Extend(Vec3(p.x(), p.y(), 0));
  if (box.empty()) box.Extend(Vec3::Zero());
  const double half_mm = views.field_mm / 2;
  if (half_mm > 0) {
    box.Extend(Vec3(-half_mm, -half_mm, 0));
    box.Extend(Vec3(half_mm, half_mm, 0));
  }
  return box;
}

void DrawWays(Canvas& canvas, const MarkViews& views, const MarkScale& scale,
              bool faults) {
  std::size_t rings = 0;
  for (const ShownMark& mark : views.marks) {
    if (mark.way_mm.empty() || faults != (mark.state != MarkState::kMade)) continue;
    const Color color = ColorOf(mark.state);
    for (std::size_t i = 1; i < mark.way_mm.size(); ++i) {
      if (!mark.IsLitTo(i)) continue;
      DrawLine(canvas, scale(mark.way_mm[i - 1]), scale(mark.way_mm[i]),
               faults ? 2.2 : 1.3, {color, faults ? 1.0F : 0.85F});
    }
    if (mark.way_mm.size() == 1)
      DrawDisc(canvas, scale(mark.way_mm.front()), 2.5, {color});
    if (!faults || ++rings > kMaxRings) continue;
    const Vec2 middle_px = scale(mark.middle_mm);
    constexpr int kCorners = 24;
    for (int i = 0; i < kCorners; ++i) {
      const auto at = [&](int corner) {
        const double rad = 2 * std::numbers::pi * corner / kCorners;
        return Vec2(middle_px + 13 * Vec2(std::cos(rad), std::sin(rad)));
      };
      DrawLine(canvas, at(i), at(i + 1), 1.6, {color});
    }
  }
}

void DrawArrow(Canvas& canvas, const Vec2& from_px, const Vec2& to_px,
               const Color& color) {
  DrawLine(canvas, from_px, to_px, 1.6, {color});
  DrawDisc(canvas, from_px, 1.8, {color});
  const Vec2 way = to_px - from_px;
  if (way.norm() < 6) return;
  const Vec2 along = way.normalized(), across(-along.y(), along.x());
  FillConvex(canvas,
             {to_px, to_px - 7 * along + 3 * across, to_px - 7 * along - 3 * across},
             {color});
}

void DrawOffsets(Canvas& canvas, const MarkViews& views, const MarkScale& scale,
                 double by) {
  std::map<std::pair<int, int>, const ShownMark*> longest;
  for (const ShownMark& mark : views.marks) {
    if (!mark.offset_mm) continue;
    const Vec2 px = scale(mark.middle_mm) / kArrowCellPx;
    const ShownMark*& kept =
        longest[{static_cast<int>(px.x()), static_cast<int>(px.y())}];
    if (kept == nullptr || mark.offset_mm->norm() > kept->offset_mm->norm()) kept = &mark;
  }
  const Palette palette;
  for (const auto& [cell, mark] : longest) {
    const bool beyond = 1e3 * mark->offset_mm->norm() > views.tolerance_um;
    DrawArrow(canvas, scale(mark->middle_mm),
              scale(mark->middle_mm + by * *mark->offset_mm),
              beyond ? palette.bad : palette.warning);
  }
}

/// The meaning of the colours that occur, below the view.
void DrawKey(Canvas& canvas, const Rect& cell, const MarkViews& views, double by) {
  constexpr std::array<std::pair<MarkState, const char*>, 6> kStates = {
      {{MarkState::kMade, "made"},
       {MarkState::kSkipped, "skipped"},
       {MarkState::kMissed, "missed"},
       {MarkState::kIncomplete, "incomplete"},
       {MarkState::kDoubled, "doubled"},
       {MarkState::kUncertain, "uncertain"}}};
  const Palette palette;
  const double y_px = cell.bottom() - 14;
  double x_px = cell.x + 18;
  const auto entry = [&](const Color& color, const std::string& text) {
    DrawLine(canvas, {x_px, y_px - 4}, {x_px + 22, y_px - 4}, 3, {color});
    DrawText(canvas, {x_px + 30, y_px}, text,
             {.cap_height_px = 9.5, .color = palette.dim_text});
    x_px += 30 + TextWidth(text, 9.5) + 26;
  };
  for (const auto& [state, name] : kStates) {
    if (std::ranges::find(views.marks, state, &ShownMark::state) != views.marks.end())
      entry(ColorOf(state), name);
  }
  if (by > 0)
    entry(palette.warning, fmt::format("error of place, {} times as long; red: beyond "
                                       "the tolerance",
                                       ShortNumber(by)));
}

}  // namespace

const Color& ColorOf(MarkState state) {
  static const std::array<Color, 6> colors = {Srgb(0x62C7F2), Srgb(0x7C8A9C),
                                              Srgb(0xFF4D4D), Srgb(0xFF9A3C),
                                              Srgb(0xE76BF3), Srgb(0xFFE45C)};
  return colors[static_cast<std::size_t>(state)];
}

double RoundBelow(double limit) {
  const double power = std::pow(10, std::floor(std::log10(limit)));
  const double digit = limit / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

MarkScale FitInto(const Rect& room, const Box3& box_mm) {
  const Vec2 size_mm = box_mm.size_mm().head<2>().cwiseMax(1e-3);
  MarkScale scale;
  scale.px_per_mm = std::min(room.width / size_mm.x(), room.height / size_mm.y());
  scale.middle_mm = box_mm.center_mm().head<2>();
  scale.middle_px = {room.x + 0.5 * room.width, room.y + 0.5 * room.height};
  return scale;
}

int OverviewHeight(const MarkViews& views, int width_px, int min_px, int max_px) {
  const Vec3 size_mm = ExtentOfViews(views).size_mm().cwiseMax(1e-3);
  const double room = (width_px - 2.0 * kOverviewMarginPx) * size_mm.y() / size_mm.x() +
                      2 * kOverviewMarginPx;
  return std::clamp(static_cast<int>(room) + kOverviewTopPx + kKeyPx, min_px, max_px);
}

double OffsetMagnification(const std::vector<ShownMark>& marks, double px_per_mm) {
  double longest_mm = 0;
  for (const ShownMark& mark : marks)
    if (mark.offset_mm)
      longest_mm = std::max({longest_mm, mark.offset_mm->norm(), kNoticedMm});
  if (longest_mm == 0) return 1;
  return std::max(1.0, RoundBelow(kLongestArrowPx / (px_per_mm * longest_mm)));
}

void DrawOverview(Canvas& canvas, const Rect& cell, const MarkViews& views) {
  const Palette palette;
  DrawCell(canvas, cell, "Marks", views.heading);
  const Rect room{cell.x + kOverviewMarginPx,
                  cell.y + kOverviewTopPx + kOverviewMarginPx / 2,
                  cell.width - 2 * kOverviewMarginPx,
                  cell.height - kOverviewTopPx - kKeyPx - kOverviewMarginPx};
  const MarkScale scale = FitInto(room, ExtentOfViews(views));
  DrawScaleBar(canvas, cell, scale.px_per_mm);
  if (views.field_mm > 0) {
    const double half_mm = views.field_mm / 2;
    const std::array<Vec2, 5> corners = {
        Vec2(-half_mm, -half_mm), Vec2(half_mm, -half_mm), Vec2(half_mm, half_mm),
        Vec2(-half_mm, half_mm), Vec2(-half_mm, -half_mm)};
    for (std::size_t i = 1; i < corners.size(); ++i)
      DrawLine(canvas, scale(corners[i - 1]), scale(corners[i]), 1, {palette.grid, 0.4F});
  }
  DrawWays(canvas, views, scale, false);
  const bool measured = std::ranges::any_of(
      views.marks, [](const ShownMark& mark) { return mark.offset_mm.has_value(); });
  const double by = measured ? OffsetMagnification(views.marks, scale.px_per_mm) : 0;
  if (measured) DrawOffsets(canvas, views, scale, by);
  DrawWays(canvas, views, scale, true);
  DrawKey(canvas, cell, views, by);
}

}  // namespace intaglio::render
