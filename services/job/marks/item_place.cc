#include "services/job/marks/item_place.h"

#include <limits>
#include <numbers>
#include <span>

namespace intaglio {
namespace {

Eigen::Matrix2d Turn(double angle_rad) {
  return Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
}

double AngleOf(const MarkPlacement& placement) {
  return placement.rotate_deg() * std::numbers::pi / 180;
}

/// Of points as the placement turns them.
struct TurnedBox {
  explicit TurnedBox(const MarkPlacement& placement) : turn(Turn(AngleOf(placement))) {}

  void Add(std::span<const Vec2> points_mm) {
    for (const Vec2& p : points_mm) {
      const Vec2 turned = turn * p;
      min_mm = min_mm.cwiseMin(turned);
      max_mm = max_mm.cwiseMax(turned);
    }
  }
  bool empty() const { return !(min_mm.x() <= max_mm.x()); }

  Eigen::Matrix2d turn;
  Vec2 min_mm = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 max_mm = -min_mm;
};

double ScaleFor(const MarkPlacement& placement, const TurnedBox& box) {
  if (placement.fit_case() == MarkPlacement::FIT_NOT_SET || box.empty())
    return placement.scale_ratio();
  const Vec2 size_mm = box.max_mm - box.min_mm;
  const bool by_width = placement.fit_case() == MarkPlacement::kFitWidthMm;
  const double asked_mm = by_width ? placement.fit_width_mm() : placement.fit_height_mm();
  const double is_mm = by_width ? size_mm.x() : size_mm.y();
  return is_mm > 0 ? asked_mm / is_mm : placement.scale_ratio();
}

TurnedBox BoxOf(const MarkPlacement& placement, const MarkShapes& shapes) {
  TurnedBox box(placement);
  if (shapes.extent_mm) {
    box.Add(CornersOf(*shapes.extent_mm));
  } else {
    for (const MarkShape& shape : shapes.shapes) box.Add(shape.places_mm);
  }
  return box;
}

}  // namespace

std::vector<Vec2> CornersOf(const Box3& box_mm) {
  const Vec3 a = box_mm.min_mm, b = box_mm.max_mm;
  return {{a.x(), a.y()}, {b.x(), a.y()}, {b.x(), b.y()}, {a.x(), b.y()}};
}

double ScaleOfItem(const MarkPlacement& placement, const std::vector<Vec2>& points_mm) {
  TurnedBox box(placement);
  box.Add(points_mm);
  return ScaleFor(placement, box);
}

ItemPlace PlaceOf(const MarkPlacement& placement, const MarkShapes& shapes) {
  const TurnedBox box = BoxOf(placement, shapes);
  ItemPlace place;
  place.angle_rad = AngleOf(placement);
  place.scale = shapes.is_scaled ? 1 : ScaleFor(placement, box);
  place.linear = place.scale * Turn(place.angle_rad);
  place.offset_mm = {placement.move_x_mm(), placement.move_y_mm()};
  if (placement.centre() && !box.empty())
    place.offset_mm -= place.scale * (0.5 * (box.min_mm + box.max_mm));
  return place;
}

}  // namespace intaglio
