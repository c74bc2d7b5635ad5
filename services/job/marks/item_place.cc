#include "services/job/marks/item_place.h"

#include <cmath>
#include <numbers>

namespace intaglio {
namespace {

Box3 BoxOf(const std::vector<Vec2>& points_mm) {
  Box3 box;
  for (const Vec2& p : points_mm) box.Extend(Vec3(p.x(), p.y(), 0));
  return box;
}

Eigen::Matrix2d Turn(double angle_rad) {
  return Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
}

double AngleOf(const MarkPlacement& placement) {
  return placement.rotate_deg() * std::numbers::pi / 180;
}

std::vector<Vec2> Turned(std::vector<Vec2> points_mm, double angle_rad) {
  const Eigen::Matrix2d turn = Turn(angle_rad);
  for (Vec2& p : points_mm) p = turn * p;
  return points_mm;
}

std::vector<Vec2> PointsOf(const MarkShapes& shapes) {
  if (shapes.extent_mm) return CornersOf(*shapes.extent_mm);
  std::vector<Vec2> points_mm;
  for (const MarkShape& shape : shapes.shapes)
    points_mm.insert(points_mm.end(), shape.places_mm.begin(), shape.places_mm.end());
  return points_mm;
}

}  // namespace

std::vector<Vec2> CornersOf(const Box3& box_mm) {
  const Vec3 a = box_mm.min_mm, b = box_mm.max_mm;
  return {{a.x(), a.y()}, {b.x(), a.y()}, {b.x(), b.y()}, {a.x(), b.y()}};
}

double ScaleOfItem(const MarkPlacement& placement, const std::vector<Vec2>& points_mm) {
  const Vec3 size_mm = BoxOf(Turned(points_mm, AngleOf(placement))).size_mm();
  const bool by_width = placement.fit_case() == MarkPlacement::kFitWidthMm;
  const double asked_mm = by_width ? placement.fit_width_mm() : placement.fit_height_mm();
  const double is_mm = by_width ? size_mm.x() : size_mm.y();
  const bool fits = placement.fit_case() != MarkPlacement::FIT_NOT_SET && is_mm > 0;
  return fits ? asked_mm / is_mm : placement.scale_ratio();
}

ItemPlace PlaceOf(const MarkPlacement& placement, const MarkShapes& shapes) {
  const std::vector<Vec2> points_mm = PointsOf(shapes);
  ItemPlace place;
  place.angle_rad = AngleOf(placement);
  place.scale = shapes.is_scaled ? 1 : ScaleOfItem(placement, points_mm);
  place.linear = place.scale * Turn(place.angle_rad);
  place.offset_mm = {placement.move_x_mm(), placement.move_y_mm()};
  if (placement.centre() && !points_mm.empty()) {
    const Box3 box = BoxOf(Turned(points_mm, place.angle_rad));
    place.offset_mm -= place.scale * box.center_mm().head<2>();
  }
  return place;
}

}  // namespace intaglio
