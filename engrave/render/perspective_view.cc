#include <algorithm>
#include <cmath>

#include "engrave/render/block_drawing.h"
#include "engrave/render/cloud_image.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

/// Room around the box for heading, numbers, axis names and the beam.
Rect RoomForBox(const Rect& cell) {
  return {cell.x + 76, cell.y + 84, cell.width - 140, cell.height - 146};
}

class BoxAxes {
 public:
  /// grid_step_mm 0: by the size of the box.
  BoxAxes(Canvas& canvas, const Box3& box_mm, const Projection& projection,
          double grid_step_mm)
      : canvas_(canvas),
        box_mm_(box_mm),
        projection_(projection),
        grid_step_mm_(grid_step_mm) {}

  void DrawFloorGrid() {
    const Vec3 size_mm = box_mm_.size_mm();
    const double fine_mm = FloorStep(box_mm_, grid_step_mm_);
    for (int axis = 0; axis < 2; ++axis) {
      const int other = 1 - axis;
      for (double mm = First(axis, fine_mm); mm < box_mm_.max_mm[axis] - 1e-9 * fine_mm;
           mm += fine_mm) {
        Vec3 from_mm = box_mm_.min_mm;
        from_mm[axis] = mm;
        const Vec3 to_mm = from_mm + size_mm[other] * Vec3::Unit(other);
        DrawLine(canvas_, Place(from_mm), Place(to_mm), 1.0, {palette_.grid, 0.10F});
      }
    }
  }

  void DrawNumbers() {
    // Along the lower front edge, the lower right edge, and the left front edge.
    const Vec3 corner_mm = box_mm_.min_mm;
    DrawAxis(0, corner_mm, "x, mm");
    DrawAxis(1, Vec3(box_mm_.max_mm.x(), corner_mm.y(), corner_mm.z()), "y, mm");
    DrawAxis(2, corner_mm, "z, mm");
  }

  /// Where the laser comes from.
  void DrawBeam() {
    const Vec3 middle_mm = box_mm_.center_mm();
    const Vec2 tip_px = Place({middle_mm.x(), middle_mm.y(), box_mm_.max_mm.z()});
    const Vec2 up_px = projection_.PictureDirection(Vec3::UnitZ());
    const Vec2 side_px(-up_px.y(), up_px.x());
    const Vec2 tail_px = tip_px + 72 * up_px;
    DrawLine(canvas_, tail_px, tip_px, 7.0, {palette_.beam, 0.05F});
    DrawLine(canvas_, tail_px, tip_px, 1.4, {palette_.beam, 0.7F});
    FillConvex(
        canvas_,
        {tip_px, tip_px + 13 * up_px - 5 * side_px, tip_px + 13 * up_px + 5 * side_px},
        {palette_.beam, 0.85F});
    DrawText(canvas_, tail_px + Vec2(10, 10), "beam",
             {.cap_height_px = 10.0, .color = palette_.beam, .alpha = 0.8F});
  }

 private:
  Vec2 Place(const Vec3& p_mm) const { return projection_(p_mm).at_px; }

  /// The first multiple of the step in the box.
  double First(int axis, double step_mm) const {
    return step_mm * std::ceil(box_mm_.min_mm[axis] / step_mm - 1e-9);
  }

  void DrawAxis(int axis, const Vec3& from_mm, const char* name) {
    const double length_mm = box_mm_.size_mm()[axis];
    const double step_mm = NiceStep(box_mm_.size_mm().maxCoeff(), 8);
    const Vec2 middle_px = Place(box_mm_.center_mm());
    const Vec2 a_px = Place(from_mm);
    const Vec2 b_px = Place(from_mm + length_mm * Vec3::Unit(axis));
    // Outwards: across the edge, away from the middle of the box.
    const Vec2 along = (b_px - a_px).normalized();
    Vec2 outward(-along.y(), along.x());
    if (outward.dot(0.5 * (a_px + b_px) - middle_px) < 0.0) outward = -outward;
    TextStyle style{.cap_height_px = 9.5, .color = palette_.dim_text};
    style.align = axis == 2 ? Align::kRight : Align::kCenter;
    const Vec2 drop(0.0, axis == 2 ? 5.0 : 6.0);
    const double end_mm = box_mm_.max_mm[axis] + 1e-9 * step_mm;
    for (double mm = First(axis, step_mm); mm <= end_mm; mm += step_mm) {
      Vec3 place_mm = from_mm;
      place_mm[axis] = mm;
      const Vec2 at_px = Place(place_mm);
      DrawLine(canvas_, at_px + 2.0 * outward, at_px + 7.0 * outward, 1.0,
               {palette_.dim_text});
      // The corner belongs to both axes: one number is enough.
      if (axis == 1 && mm < from_mm.y() + 1e-9 * step_mm) continue;
      // A step that is no binary fraction adds up to almost 0.
      const double shown_mm = std::abs(mm) < 1e-9 * step_mm ? 0.0 : mm;
      DrawText(canvas_, at_px + (axis == 2 ? 11.0 : 20.0) * outward + drop,
               ShortNumber(shown_mm), style);
    }
    TextStyle title{.cap_height_px = 10.5, .color = palette_.text};
    title.align = Align::kCenter;
    const Vec2 name_px = 0.5 * (a_px + b_px) + (axis == 2 ? 54.0 : 44.0) * outward + drop;
    DrawText(canvas_, name_px, name, title);
  }

  Canvas& canvas_;
  Palette palette_;
  Box3 box_mm_;
  const Projection& projection_;
  double grid_step_mm_;
};

Projection ProjectionOf(const Panel& panel) {
  const Rect room = RoomForBox(panel.cell);
  if (!panel.camera) return GlassPerspective(panel.shown_mm, room);
  const Camera& camera = *panel.camera;
  const auto make = camera.parallel ? Projection::ParallelView : Projection::Perspective;
  return make(panel.shown_mm, camera.azimuth_rad, camera.elevation_rad, room,
              camera.roll_rad);
}

/// A frame around the work, and how large it is; not of work that reaches beyond what is
/// shown.
void DrawWorkFrame(Canvas& canvas, const Panel& panel, const Projection& projection) {
  const Box3& work_mm = *panel.work_mm;
  if (!panel.shown_mm.Contains(work_mm.min_mm) ||
      !panel.shown_mm.Contains(work_mm.max_mm)) {
    return;
  }
  BlockDrawing frame(canvas, work_mm, projection,
                     {.faces = 0.0F, .edges = 0.6F, .edge_width = 0.7});
  frame.DrawBehind();
  frame.DrawInFront();
  DrawText(
      canvas, projection(work_mm.max_mm).at_px + Vec2(-8, -8),
      SizeNumbers({work_mm.size_mm().x(), work_mm.size_mm().y(), work_mm.size_mm().z()}),
      {.cap_height_px = 10.0, .color = Palette().text, .align = Align::kRight});
}

}  // namespace

double GridStep(double asked_mm, double chosen_mm, double range_mm) {
  constexpr double kMaxLines = 500;
  if (asked_mm <= 0) return chosen_mm;
  return asked_mm * std::max(1.0, std::ceil(range_mm / (kMaxLines * asked_mm)));
}

double MiddleScale(const Panel& panel) {
  const Projection projection = ProjectionOf(panel);
  return projection.px_per_mm(projection(panel.shown_mm.center_mm()).depth_mm);
}

double FloorStep(const Box3& box_mm, double asked_mm) {
  const double length_mm = box_mm.size_mm().maxCoeff();
  return GridStep(asked_mm, NiceStep(length_mm, 16), length_mm);
}

double PerspectiveScale(const Rect& cell, const Box3& box_mm) {
  return GlassPerspective(box_mm, RoomForBox(cell))
      .px_per_mm(3.0 * box_mm.size_mm().norm());
}

void DrawPerspectiveView(Canvas& canvas, const Panel& panel, const PointList& cracks_mm) {
  DrawCell(canvas, panel.cell, panel.name, panel.description);
  const Projection projection = ProjectionOf(panel);
  BlockDrawing block(canvas, panel.shown_mm, projection,
                     {.edges = panel.whole_block ? 1.0F : 0.5F});
  BoxAxes axes(canvas, panel.shown_mm, projection, panel.grid_step_mm);
  block.DrawBehind();
  axes.DrawFloorGrid();
  DrawCloud(canvas, panel.cell.Inset(1), projection, cracks_mm);
  block.DrawInFront();
  if (panel.work_mm) DrawWorkFrame(canvas, panel, projection);
  axes.DrawNumbers();
  if (panel.whole_block) axes.DrawBeam();
  DrawStatus(canvas, panel);
}

}  // namespace intaglio::render
