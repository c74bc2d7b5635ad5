#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/render/cloud_image.h"
#include "engrave/render/projection.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};
constexpr double kNumberCapPx = 9.0;

/// Room around the block's face for heading, numbers and axis names.
constexpr int kLeftPx = 58;
constexpr int kRightPx = 26;
constexpr int kTopPx = 66;
constexpr int kBottomPx = 52;

Rect Inner(const Rect& cell) {
  return {cell.x + kLeftPx, cell.y + kTopPx, cell.width - kLeftPx - kRightPx,
          cell.height - kTopPx - kBottomPx};
}

/// The face of the block in the picture.
struct Face {
  double left_px, right_px, top_px, bottom_px;
  double width_mm, height_mm, px_per_mm;

  double x_px(double mm) const { return left_px + mm * px_per_mm; }
  double y_px(double mm) const { return bottom_px - mm * px_per_mm; }
};

void DrawGrid(Canvas& canvas, const Face& face) {
  const Palette palette;
  const double fine_mm = NiceStep(60.0 / face.px_per_mm, 6);
  const double coarse_mm = NiceStep(60.0 / face.px_per_mm, 1);
  // A half step past the end is rounding; a whole one would leave the block.
  for (int i = 1; i * fine_mm < face.width_mm * (1 - 1e-9); ++i) {
    const double at_px = std::floor(face.x_px(i * fine_mm)) + 0.5;
    const bool coarse = std::abs(std::remainder(i * fine_mm, coarse_mm)) < 1e-6 * fine_mm;
    DrawLine(canvas, {at_px, face.top_px}, {at_px, face.bottom_px}, 1.0,
             {palette.grid, coarse ? 0.11F : 0.035F});
  }
  for (int i = 1; i * fine_mm < face.height_mm * (1 - 1e-9); ++i) {
    const double at_px = std::floor(face.y_px(i * fine_mm)) + 0.5;
    const bool coarse = std::abs(std::remainder(i * fine_mm, coarse_mm)) < 1e-6 * fine_mm;
    DrawLine(canvas, {face.left_px, at_px}, {face.right_px, at_px}, 1.0,
             {palette.grid, coarse ? 0.11F : 0.035F});
  }
}

void DrawNumbers(Canvas& canvas, const Face& face, const OrthographicView& view) {
  const Palette palette;
  const double step_mm = NiceStep(60.0 / face.px_per_mm, 1);
  TextStyle style{.cap_height_px = kNumberCapPx, .color = palette.dim_text};
  style.align = Align::kCenter;
  const double below_px = face.bottom_px + 20.0;
  for (int i = 0; i * step_mm <= face.width_mm * (1 + 1e-9); ++i) {
    const double at_px = std::floor(face.x_px(i * step_mm)) + 0.5;
    DrawLine(canvas, {at_px, face.bottom_px + 1}, {at_px, face.bottom_px + 5}, 1.0,
             {palette.dim_text});
    DrawText(canvas, {at_px, below_px}, ShortNumber(i * step_mm), style);
  }
  style.align = Align::kRight;
  for (int i = 0; i * step_mm <= face.height_mm * (1 + 1e-9); ++i) {
    const double at_px = std::floor(face.y_px(i * step_mm)) + 0.5;
    DrawLine(canvas, {face.left_px - 5, at_px}, {face.left_px - 1, at_px}, 1.0,
             {palette.dim_text});
    DrawText(canvas, {face.left_px - 9, at_px + kNumberCapPx / 2},
             ShortNumber(i * step_mm), style);
  }
  TextStyle name{.cap_height_px = 10.0, .color = palette.text};
  name.align = Align::kCenter;
  DrawText(canvas, {0.5 * (face.left_px + face.right_px), below_px + 20},
           std::string(kAxisNames[static_cast<std::size_t>(view.right_axis)]) + ", mm",
           name);
  name.align = Align::kLeft;
  DrawText(canvas, {face.left_px, face.top_px - 11},
           std::string(kAxisNames[static_cast<std::size_t>(view.up_axis)]) + ", mm",
           name);
}

}  // namespace

void DrawScaleBar(Canvas& canvas, const Rect& cell, double px_per_mm) {
  const Palette palette;
  const double length_mm = NiceStep(90.0 / px_per_mm, 1);
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

double FittingScale(const Rect& cell, const OrthographicView& view,
                    const Vec3& block_size_mm) {
  const Rect inner = Inner(cell);
  return std::min(inner.width / block_size_mm[view.right_axis],
                  inner.height / block_size_mm[view.up_axis]);
}

void DrawOrthographicView(Canvas& canvas, const Rect& cell, const OrthographicView& view,
                          double px_per_mm, const PointList& cracks_mm,
                          const Vec3& block_size_mm) {
  const Palette palette;
  DrawCell(canvas, cell, view.title, view.from);
  DrawScaleBar(canvas, cell, px_per_mm);
  const Rect inner = Inner(cell);
  const Vec2 center_px(inner.x + 0.5 * inner.width, inner.y + 0.5 * inner.height);
  Face face{};
  face.px_per_mm = px_per_mm;
  face.width_mm = block_size_mm[view.right_axis];
  face.height_mm = block_size_mm[view.up_axis];
  face.left_px = center_px.x() - 0.5 * face.width_mm * px_per_mm;
  face.right_px = center_px.x() + 0.5 * face.width_mm * px_per_mm;
  face.top_px = center_px.y() - 0.5 * face.height_mm * px_per_mm;
  face.bottom_px = center_px.y() + 0.5 * face.height_mm * px_per_mm;
  const std::vector<Vec2> corners = {{face.left_px, face.top_px},
                                     {face.right_px, face.top_px},
                                     {face.right_px, face.bottom_px},
                                     {face.left_px, face.bottom_px}};
  FillConvex(canvas, corners, {palette.glass, 0.07F});
  DrawGrid(canvas, face);
  const Projection projection =
      Projection::Parallel(Vec3::Unit(view.right_axis), Vec3::Unit(view.up_axis),
                           0.5 * block_size_mm, center_px, px_per_mm);
  DrawCloud(canvas, cell.Inset(1), projection, cracks_mm);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& next = corners[(i + 1) % corners.size()];
    DrawLine(canvas, corners[i], next, 5.0, {palette.edge, 0.05F});
    DrawLine(canvas, corners[i], next, 1.3, {palette.edge, 0.75F});
  }
  DrawNumbers(canvas, face, view);
}

}  // namespace intaglio::render
