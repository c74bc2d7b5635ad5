#include "engrave/render/views_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

constexpr double kFlatRatio = 0.03;
constexpr double kThinRatio = 0.5;    // a rod is no plane
constexpr double kSmallRatio = 0.45;  // of work that is shown larger than its block
constexpr int kHeadingPx = 118;       // what a parallel view needs above and below

Box3 BoundsOf(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  return box;
}

std::string SizeText(double width_mm, double height_mm) {
  return fmt::format("{:.4g} x {:.4g} mm", width_mm, height_mm);
}

Panel PanelOf(PanelKind kind, const Rect& cell, const Box3& shown_mm, bool whole_block) {
  Panel panel;
  panel.kind = kind;
  panel.cell = cell;
  panel.shown_mm = shown_mm;
  panel.whole_block = whole_block;
  if (kind == PanelKind::kPerspective) {
    panel.name = whole_block ? "Block" : "Close up";
    panel.description = whole_block ? "in perspective" : "the part with the work";
  } else {
    const OrthographicView view = ViewOf(kind);
    panel.name = view.title;
    panel.description = view.from;
    panel.px_per_mm = FittingScale(cell, view, shown_mm.size_mm());
  }
  return panel;
}

PanelKind KindAlong(int axis) {
  return axis == 0   ? PanelKind::kFromRight
         : axis == 1 ? PanelKind::kFromFront
                     : PanelKind::kFromAbove;
}

/// As much of the block around `shown_mm` as fits the cell at the same scale.
Box3 Widened(const Box3& shown_mm, const OrthographicView& view, const Rect& cell,
             const Vec3& block_size_mm) {
  const Vec2 room_mm = RoomIn(cell) / FittingScale(cell, view, shown_mm.size_mm());
  Box3 wide = shown_mm;
  for (const auto& [axis, room] :
       {std::pair{view.right_axis, room_mm.x()}, std::pair{view.up_axis, room_mm.y()}}) {
    const double length_mm = std::min(room, block_size_mm[axis]);
    const double low_mm = std::clamp(shown_mm.center_mm()[axis] - 0.5 * length_mm, 0.0,
                                     block_size_mm[axis] - length_mm);
    wide.min_mm[axis] = low_mm;
    wide.max_mm[axis] = low_mm + length_mm;
  }
  return wide;
}

/// One common scale for the parallel views.
void ShareScale(std::vector<Panel>& panels) {
  double scale = panels.back().px_per_mm;
  for (const Panel& panel : panels) {
    if (panel.kind != PanelKind::kPerspective) scale = std::min(scale, panel.px_per_mm);
  }
  for (Panel& panel : panels) panel.px_per_mm = scale;
}

struct Cells {
  Rect perspective, front, right, above;
};

/// The perspective view above, the others in a row below it.
Cells WideCells(const Rect& room, const Vec3& block_mm) {
  const int width = (room.width - 2 * kCellGapPx) / 3;
  const double scale = (width - 84) / std::max(block_mm.x(), block_mm.y());
  const double needed = scale * std::max(block_mm.z(), block_mm.y()) + kHeadingPx;
  const int height = static_cast<int>(std::clamp(needed, 250.0, 420.0));
  const int top = room.bottom() - height;
  const int step = width + kCellGapPx;
  return {{room.x, room.y, room.width, room.height - height - kCellGapPx},
          {room.x, top, width, height},
          {room.x + step, top, width, height},
          {room.x + 2 * step, top, room.right() - room.x - 2 * step, height}};
}

/// The perspective view at the left; at the right the view from the front, the view from
/// the right beside it and the view from above below it, as in a drawing (first angle).
Cells TallCells(const Rect& room, const Vec3& block_mm) {
  const int left = static_cast<int>(0.5 * room.width);
  const int x = room.x + left + kCellGapPx;
  const int width = (room.right() - x - kCellGapPx) / 2;
  const double share = block_mm.z() / (block_mm.z() + block_mm.y());
  const int usable = room.height - kCellGapPx;
  const int upper =
      std::clamp(static_cast<int>(kHeadingPx + share * (usable - 2 * kHeadingPx)), 250,
                 usable - 250);
  return {{room.x, room.y, left, room.height},
          {x, room.y, width, upper},
          {x + width + kCellGapPx, room.y, room.right() - x - width - kCellGapPx, upper},
          {x, room.y + upper + kCellGapPx, room.right() - x, usable - upper}};
}

/// The perspective view at the left, the others in a column beside it, each as high as
/// its face of the block needs.
Cells StackedCells(const Rect& room, const Vec3& block_mm) {
  const int left = 2 * room.width / 3;
  const int x = room.x + left + kCellGapPx;
  const int width = room.right() - x;
  const int usable = room.height - 2 * kCellGapPx;
  const double faces_mm = 2.0 * block_mm.z() + block_mm.y();
  const double faces_px = usable - 3.0 * kHeadingPx;
  const int side =
      std::clamp(static_cast<int>(kHeadingPx + faces_px * block_mm.z() / faces_mm), 200,
                 usable / 2 - 100);
  const int second = room.y + side + kCellGapPx;
  const int third = second + side + kCellGapPx;
  return {{room.x, room.y, left, room.height},
          {x, room.y, width, side},
          {x, second, width, side},
          {x, third, width, room.bottom() - third}};
}

std::vector<Panel> SolidPanels(const Cells& cells, const Box3& block_mm,
                               const Box3& shown_mm, bool whole_block) {
  std::vector<Panel> panels = {
      PanelOf(PanelKind::kPerspective, cells.perspective, shown_mm, whole_block),
      PanelOf(PanelKind::kFromFront, cells.front, block_mm, true),
      PanelOf(PanelKind::kFromRight, cells.right, block_mm, true),
      PanelOf(PanelKind::kFromAbove, cells.above, block_mm, true)};
  ShareScale(panels);
  return panels;
}

/// How much larger everything is drawn; the perspective view counts most.
double SizeOf(const std::vector<Panel>& panels) {
  return PerspectiveScale(panels[0].cell, panels[0].shown_mm) *
         std::sqrt(panels[1].px_per_mm);
}

}  // namespace

std::optional<int> FlatAxis(const PointList& cracks_mm) {
  if (cracks_mm.size() < 2) return std::nullopt;
  const Vec3 size_mm = BoundsOf(cracks_mm).size_mm();
  if (!(size_mm.maxCoeff() > 0.0)) return std::nullopt;
  const double middle_mm = size_mm.sum() - size_mm.maxCoeff() - size_mm.minCoeff();
  for (const int axis : {1, 2, 0}) {
    if (size_mm[axis] < kFlatRatio * size_mm.maxCoeff() &&
        size_mm[axis] <= kThinRatio * middle_mm) {
      return axis;
    }
  }
  return std::nullopt;
}

Box3 ShownPart(const PointList& cracks_mm, const Vec3& block_size_mm, double min_ratio,
               std::optional<int> flat_axis) {
  const Box3 block{Vec3::Zero(), block_size_mm};
  Box3 work;
  for (const Vec3& p : cracks_mm) {
    if (block.Contains(p)) work.Extend(p);
  }
  if (work.empty() || cracks_mm.size() < 2) return block;
  double ratio = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == flat_axis) continue;
    ratio = std::max(ratio, work.size_mm()[axis] / block_size_mm[axis]);
  }
  if (ratio >= min_ratio || !(work.size_mm().maxCoeff() > 0.0)) return block;
  // A view of a line is a quarter of its length wide.
  const Vec3 half_mm = (0.6 * work.size_mm()).cwiseMax(0.12 * work.size_mm().maxCoeff());
  const Vec3 center_mm = work.center_mm();
  return {(center_mm - half_mm).cwiseMax(0.0),
          (center_mm + half_mm).cwiseMin(block_size_mm)};
}

namespace {

/// The views that are chosen by the work.
std::vector<Panel> ChosenPanels(const PointList& cracks_mm, const Vec3& block_size_mm,
                                const Rect& room) {
  const Box3 block{Vec3::Zero(), block_size_mm};
  const auto flat_axis = FlatAxis(cracks_mm);
  const Box3 shown = ShownPart(cracks_mm, block_size_mm, kSmallRatio, flat_axis);
  const bool whole = shown.size_mm() == block_size_mm;
  if (flat_axis) {
    const PanelKind kind = KindAlong(*flat_axis);
    const OrthographicView view = ViewOf(kind);
    Panel panel = PanelOf(
        kind, room, whole ? shown : Widened(shown, view, room, block_size_mm), whole);
    if (!whole) {
      panel.description +=
          ", a part of the block, which is " +
          SizeText(block_size_mm[view.right_axis], block_size_mm[view.up_axis]);
    }
    panel.is_flat = true;
    return {panel};
  }
  std::vector<Panel> best;
  double largest = 0.0;
  for (const Cells& cells :
       {WideCells(room, block_size_mm), TallCells(room, block_size_mm),
        StackedCells(room, block_size_mm)}) {
    auto panels = SolidPanels(cells, block, shown, whole);
    if (SizeOf(panels) <= largest) continue;
    largest = SizeOf(panels);
    best = std::move(panels);
  }
  return best;
}

/// One large view; zoomed, the part of the block about the work's middle or another
/// place.
Panel CameraPanel(const Camera& camera, const Box3& work_mm, const Vec3& block_size_mm,
                  const Rect& room) {
  const Vec3 half_mm = 0.5 / camera.zoom * block_size_mm;
  Vec3 center_mm = camera.middle_mm  ? *camera.middle_mm
                   : work_mm.empty() ? Vec3(0.5 * block_size_mm)
                                     : work_mm.center_mm();
  center_mm = center_mm.cwiseMax(half_mm).cwiseMin(block_size_mm - half_mm);
  const bool whole = camera.zoom == 1;
  Panel panel = PanelOf(PanelKind::kPerspective, room,
                        {center_mm - half_mm, center_mm + half_mm}, whole);
  panel.camera = camera;
  constexpr double kDegPerRad = 180 / std::numbers::pi;
  panel.description = fmt::format(
      "{}azimuth {:.0f}°, elevation {:.0f}°{}{}", camera.parallel ? "parallel, " : "",
      camera.azimuth_rad * kDegPerRad, camera.elevation_rad * kDegPerRad,
      camera.roll_rad == 0 ? ""
                           : fmt::format(", roll {:.0f}°", camera.roll_rad * kDegPerRad),
      whole ? ""
            : fmt::format(", {:.3g} times enlarged about ({:.4g}, {:.4g}, {:.4g}) mm",
                          camera.zoom, center_mm.x(), center_mm.y(), center_mm.z()));
  return panel;
}

}  // namespace

ViewsLayout LayOutViews(const PointList& cracks_mm, const Vec3& block_size_mm,
                        const ViewsCaption& caption, const ViewsOptions& options) {
  ViewsLayout layout;
  layout.page = LayOutPage(caption);
  const Box3 work_mm = BoundsOf(cracks_mm);
  layout.panels = options.camera
                      ? std::vector{CameraPanel(*options.camera, work_mm, block_size_mm,
                                                layout.page.views)}
                      : ChosenPanels(cracks_mm, block_size_mm, layout.page.views);
  for (Panel& panel : layout.panels) {
    panel.grid_step_mm = options.grid_step_mm;
    if (options.object_frame && !work_mm.empty()) panel.work_mm = work_mm;
  }
  return layout;
}

}  // namespace intaglio::render
