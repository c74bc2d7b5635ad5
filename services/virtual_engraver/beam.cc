#include "services/virtual_engraver/beam.h"

#include <cmath>
#include <numbers>

// A marginal ray heads for F in the direction d, |d| = 1, tilted by asin(NA) from -z. At
// the top face (normal N = +z) it is refracted by Snell's law in vector form,
//   t = d / n + (c / n - sqrt(1 - (1 - c^2) / n^2)) N,   c = -d . N,
// and goes on from where it met the face. The crack forms where such rays come nearest to
// the beam's axis, the vertical through F; over a ring of rays these points are averaged.

namespace intaglio::virtual_engraver {
namespace {

constexpr int kRays = 8;

Vec3 Refract(const Vec3& direction, double index) {
  const double cosine = -direction.z();
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (index * index));
  return direction / index + (cosine / index - inside) * Vec3::UnitZ();
}

/// The point of the ray p + s t that is nearest to the vertical through `axis`.
Vec3 NearestToAxis(const Vec3& p, const Vec3& t, const Vec3& axis) {
  const Vec2 away = (p - axis).head<2>(), along = t.head<2>();
  const double length = along.squaredNorm();
  return length > 0 ? Vec3(p - away.dot(along) / length * t) : axis;
}

}  // namespace

Focus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block) {
  const double top_mm = block.origin_mm.z() + block.size_mm.z();
  Vec3 meeting_mm = stage_mm;
  if (stage_mm.z() < top_mm && block.numerical_aperture > 0) {
    const double sine = block.numerical_aperture;
    const double cosine = std::sqrt(1 - sine * sine);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < kRays; ++i) {
      const double turn = 2 * std::numbers::pi * i / kRays;
      const Vec3 direction(sine * std::cos(turn), sine * std::sin(turn), -cosine);
      const Vec3 at_face = stage_mm + (top_mm - stage_mm.z()) / direction.z() * direction;
      sum += NearestToAxis(at_face, Refract(direction, block.refractive_index), stage_mm);
    }
    meeting_mm = sum / kRays;
  }
  Focus focus;
  focus.position_mm = meeting_mm - block.origin_mm;
  focus.in_glass = Box3{Vec3::Zero(), block.size_mm}.Contains(focus.position_mm);
  return focus;
}

}  // namespace intaglio::virtual_engraver
