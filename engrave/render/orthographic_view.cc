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
constexpr Margins kFaceMargins = {.left = 58, .right = 26, .top = 66, .bottom = 52};

/// What is shown of the block's face, and where.
struct Face {
  double left_px, right_px, top_px, bottom_px;
  double min_right_mm, max_right_mm, min_up_mm, max_up_mm, px_per_mm;

  double x_px(double mm) const { return left_px + (mm - min_right_mm) * px_per_mm; }
  double y_px(double mm) const { return bottom_px - (mm - min_up_mm) * px_per_mm; }
};

/// The multiples of a step within a range, from the first index to the last.
struct Multiples {
  int first, last;
};
Multiples MultiplesIn(double min_mm, double max_mm, double step_mm) {
  return {static_cast<int>(std::ceil(min_mm / step_mm - 1e-9)),
          static_cast<int>(std::floor(max_mm / step_mm + 1e-9))};
}

/// The fine step of a parallel view.
double FineStepOf(const Panel& panel) {
  const OrthographicView view = ViewOf(panel.kind);
  const Vec3 size_mm = panel.shown_mm.size_mm();
  return GridStep(panel.grid_step_mm, NiceStep(60.0 / panel.px_per_mm, 6),
                  std::max(size_mm[view.right_axis], size_mm[view.up_axis]));
}

void DrawGrid(Canvas& canvas, const Face& face, double fine_mm, double grid_step_mm) {
  const Palette palette;
  const double coarse_mm =
      grid_step_mm > 0 ? fine_mm : NiceStep(60.0 / face.px_per_mm, 1);
  const auto draw = [&](double mm, const Vec2& from_px, const Vec2& to_px) {
    const bool coarse = std::abs(std::remainder(mm, coarse_mm)) < 1e-6 * fine_mm;
    DrawLine(canvas, from_px, to_px, 1.0, {palette.grid, coarse ? 0.11F : 0.035F});
  };
  const auto across = MultiplesIn(face.min_right_mm, face.max_right_mm, fine_mm);
  for (int i = across.first; i <= across.last; ++i) {
    const double at_px = std::floor(face.x_px(i * fine_mm)) + 0.5;
    draw(i * fine_mm, {at_px, face.top_px}, {at_px, face.bottom_px});
  }
  const auto up = MultiplesIn(face.min_up_mm, face.max_up_mm, fine_mm);
  for (int i = up.first; i <= up.last; ++i) {
    const double at_px = std::floor(face.y_px(i * fine_mm)) + 0.5;
    draw(i * fine_mm, {face.left_px, at_px}, {face.right_px, at_px});
  }
}

void DrawNumbers(Canvas& canvas, const Face& face, const OrthographicView& view) {
  const Palette palette;
  const double step_mm = NiceStep(60.0 / face.px_per_mm, 1);
  TextStyle style{.cap_height_px = kNumberCapPx, .color = palette.dim_text};
  style.align = Align::kCenter;
  const double below_px = face.bottom_px + 20.0;
  const auto across = MultiplesIn(face.min_right_mm, face.max_right_mm, step_mm);
  for (int i = across.first; i <= across.last; ++i) {
    const double at_px = std::floor(face.x_px(i * step_mm)) + 0.5;
    DrawLine(canvas, {at_px, face.bottom_px + 1}, {at_px, face.bottom_px + 5}, 1.0,
             {palette.dim_text});
    DrawText(canvas, {at_px, below_px}, ShortNumber(i * step_mm), style);
  }
  style.align = Align::kRight;
  const auto up = MultiplesIn(face.min_up_mm, face.max_up_mm, step_mm);
  for (int i = up.first; i <= up.last; ++i) {
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

/// The frame of the work in this view, with its two sizes.
void DrawWorkOutline(Canvas& canvas, const Face& face, const OrthographicView& view,
                     const Box3& work_mm) {
  const Palette palette;
  const double left = face.x_px(work_mm.min_mm[view.right_axis]);
  const double right = face.x_px(work_mm.max_mm[view.right_axis]);
  const double bottom = face.y_px(work_mm.min_mm[view.up_axis]);
  const double top = face.y_px(work_mm.max_mm[view.up_axis]);
  const std::vector<Vec2> corners = {
      {left, top}, {right, top}, {right, bottom}, {left, bottom}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    DrawLine(canvas, corners[i], corners[(i + 1) % corners.size()], 1.0,
             {palette.edge, 0.5F});
  }
  const Vec3 size_mm = work_mm.size_mm();
  DrawText(canvas, {left, top - 5},
           SizeNumbers({size_mm[view.right_axis], size_mm[view.up_axis]}),
           {.cap_height_px = 9.0, .color = palette.text});
}

Face FaceOf(const Panel& panel, const OrthographicView& view, const Vec2& center_px) {
  Face face{};
  face.px_per_mm = panel.px_per_mm;
  face.min_right_mm = panel.shown_mm.min_mm[view.right_axis];
  face.max_right_mm = panel.shown_mm.max_mm[view.right_axis];
  face.min_up_mm = panel.shown_mm.min_mm[view.up_axis];
  face.max_up_mm = panel.shown_mm.max_mm[view.up_axis];
  const Vec2 half_px =
      0.5 * face.px_per_mm *
      Vec2(face.max_right_mm - face.min_right_mm, face.max_up_mm - face.min_up_mm);
  face.left_px = center_px.x() - half_px.x();
  face.right_px = center_px.x() + half_px.x();
  face.top_px = center_px.y() - half_px.y();
  face.bottom_px = center_px.y() + half_px.y();
  return face;
}

}  // namespace

double GridStepOf(const Panel& panel) {
  return panel.kind == PanelKind::kPerspective
             ? FloorStep(panel.shown_mm, panel.grid_step_mm)
             : FineStepOf(panel);
}

Vec2 RoomIn(const Rect& cell) {
  const Rect inner = cell.Inside(kFaceMargins);
  return {inner.width, inner.height};
}

double FittingScale(const Rect& cell, const OrthographicView& view, const Vec3& size_mm) {
  const Vec2 room_px = RoomIn(cell);
  return std::min(room_px.x() / size_mm[view.right_axis],
                  room_px.y() / size_mm[view.up_axis]);
}

void DrawOrthographicView(Canvas& canvas, const Panel& panel,
                          const PointList& cracks_mm) {
  const Palette palette;
  const OrthographicView view = ViewOf(panel.kind);
  DrawCell(canvas, panel.cell, panel.name, panel.description);
  DrawScaleBar(canvas, panel.cell, panel.px_per_mm);
  const Rect inner = panel.cell.Inside(kFaceMargins);
  const Vec2 center_px(inner.x + 0.5 * inner.width, inner.y + 0.5 * inner.height);
  const Face face = FaceOf(panel, view, center_px);
  const std::vector<Vec2> corners = {{face.left_px, face.top_px},
                                     {face.right_px, face.top_px},
                                     {face.right_px, face.bottom_px},
                                     {face.left_px, face.bottom_px}};
  FillConvex(canvas, corners, {palette.glass, 0.07F});
  DrawGrid(canvas, face, FineStepOf(panel), panel.grid_step_mm);
  const Projection projection =
      Projection::Parallel(Vec3::Unit(view.right_axis), Vec3::Unit(view.up_axis),
                           panel.shown_mm.center_mm(), center_px, panel.px_per_mm);
  DrawCloud(canvas, panel.cell.Inset(1), projection, cracks_mm,
            {.is_flat = panel.is_flat});
  // The edges of the block are bright, those of a part of it are not.
  const float strength = panel.whole_block ? 1.0F : 0.35F;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& next = corners[(i + 1) % corners.size()];
    DrawLine(canvas, corners[i], next, 5.0, {palette.edge, 0.05F * strength});
    DrawLine(canvas, corners[i], next, 1.3, {palette.edge, 0.75F * strength});
  }
  if (panel.work_mm) DrawWorkOutline(canvas, face, view, *panel.work_mm);
  DrawNumbers(canvas, face, view);
  DrawStatus(canvas, panel);
}

}  // namespace intaglio::render
