#include "tests/engrave/galvo/traced_head.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace intaglio::galvo {
namespace {

Vec3 Reflected(const Vec3& ray, const Vec3& normal) {
  return ray - 2 * ray.dot(normal) * normal;
}

Vec3 Turned(const Vec3& normal, double angle_rad, const Vec3& axis) {
  return Eigen::AngleAxisd(angle_rad, axis) * normal;
}

Vec3 Hit(const Vec3& from, const Vec3& ray, const Vec3& on_plane, const Vec3& normal) {
  return from + ray * ((on_plane - from).dot(normal) / ray.dot(normal));
}

}  // namespace

Vec3 TracedDirection(double ax_rad, double ay_rad) {
  const Vec3 first = Turned(Vec3(1, -1, 0).normalized(), ay_rad / 2, Vec3::UnitZ());
  const Vec3 second = Turned(Vec3(-1, 0, 1).normalized(), ax_rad / 2, Vec3::UnitY());
  return Reflected(Reflected(Vec3(0, 1, 0), first), second);
}

Vec2 TracedThroughLens(double ax_rad, double ay_rad, const std::array<double, 4>& h_mm) {
  const Vec3 ray = TracedDirection(ax_rad, ay_rad);
  const double t = std::acos(std::min(1.0, ray.z()));
  double height_mm = 0;
  for (std::size_t i = 0; i < 4; ++i)
    height_mm += h_mm[i] * std::pow(t, static_cast<double>(i + 1));
  const double azimuth_rad = std::atan2(ray.y(), ray.x());
  return height_mm * Vec2(std::cos(azimuth_rad), std::sin(azimuth_rad));
}

Vec2 TracedWithoutLens(double ax_rad, double ay_rad, double distance_mm, double gap_mm) {
  // The beam comes along +x, goes along -z to the second mirror, and down along -y; the
  // field's x is the bench's x, its y is the bench's -z.
  const Vec3 first = Turned(Vec3(-1, 0, -1).normalized(), -ax_rad / 2, Vec3::UnitY());
  const Vec3 second_at(0, 0, -gap_mm);
  const Vec3 second = Turned(Vec3(0, -1, 1).normalized(), -ay_rad / 2, Vec3::UnitX());
  const Vec3 between = Reflected(Vec3(1, 0, 0), first);
  const Vec3 at = Hit(Vec3::Zero(), between, second_at, second);
  const Vec3 field = Hit(at, Reflected(between, second),
                         second_at - distance_mm * Vec3::UnitY(), Vec3::UnitY());
  return {field.x(), field.z() + gap_mm};
}

WrongField::WrongField(double width_mm, double share, double half_angle_deg)
    : width_mm_(width_mm),
      focal_mm_(width_mm / 2 / (half_angle_deg * std::numbers::pi / 180)) {
  const double wanted_mm = share * width_mm;
  std::optional<double> nearest;
  for (double from = -1.5; from < 1.5; from += 0.025) {
    double low = from, high = from + 0.025;
    const bool low_below = Worst(low) < wanted_mm;
    if (low_below == (Worst(high) < wanted_mm)) continue;
    for (int i = 0; i < 50; ++i) {
      const double middle = (low + high) / 2;
      ((Worst(middle) < wanted_mm) == low_below ? low : high) = middle;
    }
    if (!nearest || std::abs(low) < std::abs(*nearest)) nearest = low;
  }
  if (!nearest) throw std::logic_error("no cubic term gives that share");
  cubic_ = *nearest;
  centre_mm_ = Raw(Vec2::Zero(), cubic_);
}

Vec2 WrongField::Raw(const Vec2& command_mm, double cubic) const {
  const double first_rad = 2.0 / 60 * std::numbers::pi / 180;
  return TracedThroughLens(command_mm.x() / focal_mm_ + first_rad,
                           command_mm.y() / focal_mm_,
                           {focal_mm_, 0, cubic * focal_mm_, 0});
}

double WrongField::Worst(double cubic) const {
  const Vec2 centre_mm = Raw(Vec2::Zero(), cubic);
  double worst_mm = 0;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const Vec2 at_mm = width_mm_ / 40 * Vec2(i, j);
      worst_mm = std::max(worst_mm, (Raw(at_mm, cubic) - centre_mm - at_mm).norm());
    }
  }
  return worst_mm;
}

Vec2 WrongField::Arrive(const Vec2& command_mm) const {
  return Raw(command_mm, cubic_) - centre_mm_ + Vec2(0.05, -0.05);
}

Vec2 WrongField::Inverse(const Vec2& place_mm) const {
  Vec2 command_mm = place_mm;
  for (int i = 0; i < 60; ++i) command_mm -= Arrive(command_mm) - place_mm;
  return command_mm;
}

}  // namespace intaglio::galvo
