#include "engrave/render/spacing_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engrave/render/plane.h"
#include "engrave/render/projection.h"
#include "engrave/render/text.h"

// The front of the cloud is the minimum depth at every pixel. Points a little behind it
// still count as seen, so that an oblique sheet has no gaps; their colours are averaged,
// and shaded by the slope of the front, so that the shape is visible.

namespace intaglio::render {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::infinity();
constexpr Margins kPanelMargins = {.left = 54, .right = 22, .top = 64, .bottom = 50};
// Rounding of a lattice of exactly the minimum spacing is not a fault.
constexpr double kTooNear = 1 - 1e-8;

struct SpacingSpot {
  float x_px, y_px, depth_mm;
  std::uint32_t point;
};

/// Calls paint(x, y, share) for the pixels of a disc, with the share that it covers.
template <typename Paint>
void OverDisc(float x_px, float y_px, float radius_px, const Plane& plane,
              Paint&& paint) {
  const int left = std::max(0, static_cast<int>(x_px - radius_px - 0.5F));
  const int right = std::min(plane.width - 1, static_cast<int>(x_px + radius_px + 0.5F));
  const int top = std::max(0, static_cast<int>(y_px - radius_px - 0.5F));
  const int bottom =
      std::min(plane.height - 1, static_cast<int>(y_px + radius_px + 0.5F));
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const float away = std::hypot(static_cast<float>(x) + 0.5F - x_px,
                                    static_cast<float>(y) + 0.5F - y_px);
      const float share = std::clamp(radius_px + 0.5F - away, 0.0F, 1.0F);
      if (share > 0) paint(x, y, share);
    }
  }
}

class Picture {
 public:
  Picture(const Rect& window, const Projection& projection, double px_per_mm,
          const SpacingMap& map)
      : window_(window),
        map_(map),
        px_per_mm_(static_cast<float>(px_per_mm)),
        radius_px_(std::clamp(static_cast<float>(0.45 * map.min_spacing_mm * px_per_mm),
                              0.7F, 9.0F)),
        front_(window.width, window.height, kNoDepth) {
    spots_.reserve(map.points_mm.size());
    for (std::uint32_t i = 0; i < map.points_mm.size(); ++i) {
      const Projected p = projection(map.points_mm[i]);
      spots_.push_back({static_cast<float>(p.at_px.x()) - static_cast<float>(window.x),
                        static_cast<float>(p.at_px.y()) - static_cast<float>(window.y),
                        static_cast<float>(p.depth_mm), i});
    }
    FindFront();
  }

  void Draw(Canvas& canvas) const {
    DrawSeen(canvas);
    DrawTooNear(canvas);
  }

 private:
  void FindFront() {
    // So wide that the points of a square lattice cover every pixel.
    const float radius_px = std::max(1.1F, 1.7F * radius_px_);
    for (const SpacingSpot& spot : spots_) {
      OverDisc(spot.x_px, spot.y_px, radius_px, front_, [&](int x, int y, float) {
        front_.at(x, y) = std::min(front_.at(x, y), spot.depth_mm);
      });
      min_mm_ = std::min(min_mm_, spot.depth_mm);
      max_mm_ = std::max(max_mm_, spot.depth_mm);
    }
  }

  bool IsSeen(const SpacingSpot& spot) const {
    const int x = static_cast<int>(spot.x_px), y = static_cast<int>(spot.y_px);
    const float behind_mm =
        std::max(3 * static_cast<float>(map_.min_spacing_mm), 8 / px_per_mm_);
    return front_.Has(x, y) && spot.depth_mm <= front_.at(x, y) + behind_mm;
  }

  void DrawSeen(Canvas& canvas) const {
    struct Sum {
      Color color;
      float weight = 0;
    };
    std::vector<Sum> sums(front_.values.size());
    for (const SpacingSpot& spot : spots_) {
      if (!IsSeen(spot)) continue;
      const Color color = SpacingColor(map_.nearest_mm[spot.point] / map_.min_spacing_mm);
      OverDisc(spot.x_px, spot.y_px, radius_px_, front_, [&](int x, int y, float share) {
        Sum& sum = sums[static_cast<std::size_t>(y) * front_.width + x];
        sum.color = sum.color + share * color;
        sum.weight += share;
      });
    }
    const Plane light = Shading();
    for (int y = 0; y < front_.height; ++y) {
      for (int x = 0; x < front_.width; ++x) {
        const Sum& sum = sums[static_cast<std::size_t>(y) * front_.width + x];
        if (sum.weight <= 0) continue;
        canvas.Blend(window_.x + x, window_.y + y,
                     light.at(x, y) / sum.weight * sum.color, std::min(1.0F, sum.weight));
      }
    }
  }

  /// Shades each pixel by the slope of the front, and darker towards the back.
  Plane Shading() const {
    Plane depth(front_.width, front_.height, 0), there(front_.width, front_.height, 0);
    for (std::size_t i = 0; i < front_.values.size(); ++i) {
      if (front_.values[i] == kNoDepth) continue;
      depth.values[i] = front_.values[i] - min_mm_;
      there.values[i] = 1;
    }
    depth = Blurred(std::move(depth), 2);
    there = Blurred(std::move(there), 2);
    for (std::size_t i = 0; i < depth.values.size(); ++i) {
      depth.values[i] /= std::max(there.values[i], 1e-3F);
    }
    Plane light(front_.width, front_.height, 0.8F);
    const float range_mm = std::max(max_mm_ - min_mm_, 1e-3F);
    const Vec3 sun = Vec3(-0.45, -0.6, 0.66).normalized();  // x right, y down, z to us
    for (int y = 0; y < front_.height; ++y) {
      for (int x = 0; x < front_.width; ++x) {
        const int left = std::max(x - 1, 0), right = std::min(x + 1, front_.width - 1);
        const int up = std::max(y - 1, 0), down = std::min(y + 1, front_.height - 1);
        const bool whole = there.at(left, y) > 0.3F && there.at(right, y) > 0.3F &&
                           there.at(x, up) > 0.3F && there.at(x, down) > 0.3F;
        const float dx = (depth.at(right, y) - depth.at(left, y)) * px_per_mm_ / 2;
        const float dy = (depth.at(x, down) - depth.at(x, up)) * px_per_mm_ / 2;
        const double diffuse =
            whole ? std::max(0.0, Vec3(dx, dy, 1).normalized().dot(sun)) : 0.6;
        const float fog = 1 - 0.35F * depth.at(x, y) / range_mm;
        light.at(x, y) = fog * (0.30F + 0.85F * static_cast<float>(diffuse));
      }
    }
    return light;
  }

  /// On top of everything, faint where something is in front: a fault must not be hidden.
  void DrawTooNear(Canvas& canvas) const {
    const Color color = SpacingColor(0);
    for (const SpacingSpot& spot : spots_) {
      if (map_.nearest_mm[spot.point] >= kTooNear * map_.min_spacing_mm) continue;
      const Vec2 at(window_.x + spot.x_px, window_.y + spot.y_px);
      const float alpha = IsSeen(spot) ? 0.95F : 0.25F;
      DrawDisc(canvas, at, std::max(1.8F, 1.2F * radius_px_), {color, alpha});
    }
  }

  Rect window_;
  const SpacingMap& map_;
  float px_per_mm_;
  float radius_px_;
  Plane front_;
  std::vector<SpacingSpot> spots_;
  float min_mm_ = kNoDepth, max_mm_ = -kNoDepth;
};

/// The part of the cell that the cloud takes.
struct PlotArea {
  double left_px, right_px, top_px, bottom_px;
};

void DrawNumbers(Canvas& canvas, const PlotArea& area, const OrthographicView& view,
                 double px_per_mm, const Box3& box_mm) {
  const Palette palette;
  static constexpr const char* kAxes[] = {"x", "y", "z"};
  const double step_mm = NiceStep(60.0 / px_per_mm, 1);
  TextStyle style{.cap_height_px = 9.0, .color = palette.dim_text};
  style.align = Align::kCenter;
  const double low_x = box_mm.min_mm[view.right_axis],
               low_y = box_mm.min_mm[view.up_axis];
  const double high_x = box_mm.max_mm[view.right_axis];
  const double high_y = box_mm.max_mm[view.up_axis];
  const double axis_px = area.bottom_px + 8;
  for (double mm = std::ceil(low_x / step_mm) * step_mm; mm <= high_x; mm += step_mm) {
    const double x_px = std::floor(area.left_px + (mm - low_x) * px_per_mm) + 0.5;
    DrawLine(canvas, {x_px, axis_px}, {x_px, axis_px + 4}, 1.0, {palette.dim_text});
    DrawText(canvas, {x_px, axis_px + 18}, ShortNumber(mm), style);
  }
  style.align = Align::kRight;
  const double side_px = area.left_px - 8;
  for (double mm = std::ceil(low_y / step_mm) * step_mm; mm <= high_y; mm += step_mm) {
    const double y_px = std::floor(area.bottom_px - (mm - low_y) * px_per_mm) + 0.5;
    DrawLine(canvas, {side_px - 4, y_px}, {side_px, y_px}, 1.0, {palette.dim_text});
    DrawText(canvas, {side_px - 8, y_px + 4.5}, ShortNumber(mm), style);
  }
  DrawLine(canvas, {area.left_px, axis_px}, {area.right_px, axis_px}, 1.0,
           {palette.cell_frame});
  DrawLine(canvas, {side_px, area.top_px}, {side_px, area.bottom_px}, 1.0,
           {palette.cell_frame});
  style.align = Align::kCenter;
  style.color = palette.text;
  DrawText(canvas, {0.5 * (area.left_px + area.right_px), axis_px + 35},
           std::string(kAxes[view.right_axis]) + ", mm", style);
  style.align = Align::kRight;
  DrawText(canvas, {side_px + 4, area.top_px - 8},
           std::string(kAxes[view.up_axis]) + ", mm", style);
}

}  // namespace

double FittingSpacingScale(const Rect& cell, const OrthographicView& view,
                           const Box3& box_mm) {
  const Rect inner = cell.Inside(kPanelMargins);
  const Vec3 size_mm = box_mm.size_mm();
  return std::min(inner.width / size_mm[view.right_axis],
                  inner.height / size_mm[view.up_axis]);
}

void DrawSpacingView(Canvas& canvas, const Rect& cell, const OrthographicView& view,
                     double px_per_mm, const Box3& box_mm, const SpacingMap& map) {
  DrawCell(canvas, cell, view.title, view.from);
  DrawScaleBar(canvas, cell, px_per_mm);
  const Rect inner = cell.Inside(kPanelMargins);
  const Vec2 center_px(inner.x + 0.5 * inner.width, inner.y + 0.5 * inner.height);
  const Vec3 half_px = 0.5 * px_per_mm * box_mm.size_mm();
  const PlotArea area{
      center_px.x() - half_px[view.right_axis], center_px.x() + half_px[view.right_axis],
      center_px.y() - half_px[view.up_axis], center_px.y() + half_px[view.up_axis]};
  const Projection projection =
      Projection::Parallel(Vec3::Unit(view.right_axis), Vec3::Unit(view.up_axis),
                           box_mm.center_mm(), center_px, px_per_mm);
  Picture(cell.Inset(1), projection, px_per_mm, map).Draw(canvas);
  DrawNumbers(canvas, area, view, px_per_mm, box_mm);
}

}  // namespace intaglio::render
