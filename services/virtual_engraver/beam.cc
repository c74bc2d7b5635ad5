#include "services/virtual_engraver/beam.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

// The axis of the beam heads for F; a marginal ray heads for F in a direction d, |d| = 1,
// at the angle asin(NA) to the axis. At the top face (normal N = +z) each is refracted by
// Snell's law in vector form,
//   t = d / n + (c / n - sqrt(1 - (1 - c^2) / n^2)) N,   c = -d . N,
// and goes on from where it met the face. The crack forms where marginal rays come
// nearest to the axis; over a ring of rays these points are averaged.
//
// A Gaussian beam keeps 1 / (1 + (D / 2 r)^2) of its peak in the middle of foci that are
// D apart, and 1 / sqrt(1 + (D / r)^2) at each of them, r its Rayleigh range; a cone that
// ends at 1.6 of its radius behaves as one of 0.8 D.

namespace intaglio::virtual_engraver {
namespace {

constexpr int kRays = 8;

Vec3 Refract(const Vec3& direction, double index) {
  const double cosine = -direction.z();
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (index * index));
  return direction / index + (cosine / index - inside) * Vec3::UnitZ();
}

struct Ray {
  Vec3 from_mm, way;
};

/// In the glass, of what heads for `aim_mm` below the face.
Ray IntoGlass(const Vec3& aim_mm, const Vec3& direction, double top_mm, double index) {
  return {aim_mm + (top_mm - aim_mm.z()) / direction.z() * direction,
          Refract(direction, index)};
}

/// The point of `ray` that is nearest to the line of `axis`.
Vec3 NearestToAxis(const Ray& ray, const Ray& axis) {
  const Vec3 along = axis.way.normalized();
  const auto across = [&along](const Vec3& v) { return Vec3(v - along.dot(v) * along); };
  const Vec3 away = across(ray.from_mm - axis.from_mm), leaving = across(ray.way);
  return ray.from_mm - away.dot(leaving) / leaving.squaredNorm() * ray.way;
}

}  // namespace

Focus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block, const Vec2& slopes) {
  const double top_mm = block.origin_mm.z() + block.size_mm.z();
  Focus focus;
  Vec3 meeting_mm = stage_mm;
  if (stage_mm.z() < top_mm && block.numerical_aperture > 0) {
    const double sine = block.numerical_aperture;
    const double cosine = std::sqrt(1 - sine * sine);
    const Vec3 down = Vec3(slopes.x(), slopes.y(), -1).normalized();
    // The first ray of the ring is in the plane of incidence.
    const Vec2 aside =
        slopes.norm() > 0 ? Vec2(slopes.normalized()) : Vec2(Vec2::UnitX());
    const Vec3 beside(-aside.y(), aside.x(), 0), outward = down.cross(beside);
    const Ray axis = IntoGlass(stage_mm, down, top_mm, block.refractive_index);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < kRays; ++i) {
      const double turn = 2 * std::numbers::pi * i / kRays;
      const Vec3 direction =
          cosine * down + sine * (std::cos(turn) * outward + std::sin(turn) * beside);
      const Vec3 nearest = NearestToAxis(
          IntoGlass(stage_mm, direction, top_mm, block.refractive_index), axis);
      sum += nearest;
      // In the plane of incidence at even quarters, beside it at odd ones.
      if (i % (kRays / 4) == 0)
        focus.apart_mm += (i % (kRays / 2) == 0 ? -0.5 : 0.5) * nearest.z();
    }
    meeting_mm = sum / kRays;
  }
  focus.position_mm = meeting_mm - block.origin_mm;
  focus.in_glass = Box3{Vec3::Zero(), block.size_mm}.Contains(focus.position_mm);
  return focus;
}

double PeakLeft(const BlockInMachine& block, double apart_mm, double wavelength_mm) {
  const double aperture = block.numerical_aperture;
  if (aperture <= 0) return 1;
  const double rayleigh_mm =
      block.refractive_index * wavelength_mm / (std::numbers::pi * aperture * aperture);
  const double by = 0.8 * std::abs(apart_mm) / rayleigh_mm;
  return std::max(1 / (1 + by * by / 4), 1 / std::sqrt(1 + by * by));
}

}  // namespace intaglio::virtual_engraver
