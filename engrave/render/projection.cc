#include "engrave/render/projection.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::render {
namespace {

/// a x b without Eigen's geometry module, which would be compiled for this alone.
Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

}  // namespace

Projection Projection::Parallel(const Vec3& right, const Vec3& up, const Vec3& center_mm,
                                const Vec2& center_px, double px_per_mm) {
  Projection projection;
  projection.right_ = right;
  projection.up_ = up;
  projection.forward_ = Cross(up, right);
  projection.origin_mm_ = center_mm;
  projection.place_px_ = center_px;
  projection.scale_ = px_per_mm;
  return projection;
}

Projection Projection::Perspective(const Box3& box_mm, double azimuth_rad,
                                   double elevation_rad, const Rect& into,
                                   double roll_rad) {
  const double ca = std::cos(azimuth_rad);
  const double sa = std::sin(azimuth_rad);
  const double ce = std::cos(elevation_rad);
  const double se = std::sin(elevation_rad);
  Projection projection;
  projection.central_ = true;
  projection.right_ = Vec3(ca, sa, 0.0);
  projection.forward_ = Vec3(-sa * ce, ca * ce, -se);
  projection.up_ = Cross(projection.right_, projection.forward_);
  projection.Roll(roll_rad);
  const double distance_mm = 3.0 * box_mm.size_mm().norm();
  projection.origin_mm_ = box_mm.center_mm() - distance_mm * projection.forward_;
  projection.FitInto(box_mm, into);
  return projection;
}

Projection Projection::ParallelView(const Box3& box_mm, double azimuth_rad,
                                    double elevation_rad, const Rect& into,
                                    double roll_rad) {
  const double ca = std::cos(azimuth_rad), sa = std::sin(azimuth_rad);
  const double ce = std::cos(elevation_rad), se = std::sin(elevation_rad);
  const Vec3 right(ca, sa, 0.0);
  Projection projection = Parallel(right, Cross(right, Vec3(-sa * ce, ca * ce, -se)),
                                   box_mm.center_mm(), Vec2::Zero(), 1.0);
  projection.Roll(roll_rad);
  projection.FitInto(box_mm, into);
  return projection;
}

void Projection::Roll(double roll_rad) {
  const Vec3 right = right_, up = up_;
  right_ = std::cos(roll_rad) * right - std::sin(roll_rad) * up;
  up_ = std::sin(roll_rad) * right + std::cos(roll_rad) * up;
}

void Projection::FitInto(const Box3& box_mm, const Rect& into) {
  place_px_ = Vec2::Zero();
  scale_ = 1.0;
  Vec2 low = Vec2::Constant(1e300);
  Vec2 high = -low;
  for (const Vec3& corner : CornersOf(box_mm)) {
    const Vec2 at = (*this)(corner).at_px;
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Vec2 span = high - low;
  scale_ = std::min(into.width / span.x(), into.height / span.y());
  place_px_ = Vec2(into.x + 0.5 * into.width, into.y + 0.5 * into.height) -
              0.5 * scale_ * (low + high);
}

bool Projection::Sees(const Vec3& normal, const Vec3& place_mm) const {
  const Vec3 sight = central_ ? Vec3(place_mm - origin_mm_) : forward_;
  return normal.dot(sight) < 0.0;
}

std::vector<Vec3> CornersOf(const Box3& box_mm) {
  std::vector<Vec3> corners;
  for (unsigned i = 0; i < 8; ++i) {
    Vec3 corner_mm = box_mm.min_mm;
    for (unsigned axis = 0; axis < 3; ++axis) {
      if ((i >> axis & 1U) != 0) corner_mm[axis] = box_mm.max_mm[axis];
    }
    corners.push_back(corner_mm);
  }
  return corners;
}

double NiceStep(double range, int largest) {
  Require(range > 0.0 && largest > 0, "no step for a range of {} in {}", range, largest);
  const double smallest = range / largest;
  const double power = std::pow(10.0, std::floor(std::log10(smallest)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= smallest * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace intaglio::render
