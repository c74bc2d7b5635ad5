#include "engrave/optics/oblique_focus.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// With k = 1 - 1/n^2, slopes tx, ty, q = k (tx^2 + ty^2), c = sqrt(1 + q):
//   x = u + h tx q / 2,  z = n h c (1 + q / 2)
//   dq/du = 2 k tx / Lx,  dc/dq = 1 / (2 c)
//   dz/dq = n h ((1 + q / 2) / (2 c) + c / 2)

namespace intaglio::optics {
namespace {

constexpr int kMaxSteps = 20;
constexpr double kMaxTangent = 1;  // 45 degrees

double BendOf(double refractive_index) {
  return 1 - 1 / (refractive_index * refractive_index);
}

void CheckIndex(double refractive_index) {
  Require(refractive_index >= 1, "refractive_index must be 1 or more, is {}",
          refractive_index);
}

}  // namespace

LineFoci FociOf(const HeadPosition& head, const ScanLens& lens, double refractive_index) {
  CheckIndex(refractive_index);
  const double q = lens.SlopesAt(head.field_mm).squaredNorm() * BendOf(refractive_index);
  const double sagittal_mm = refractive_index * head.below_face_mm * std::sqrt(1 + q);
  return {sagittal_mm, sagittal_mm * (1 + q)};
}

LineFoci FociAtDepth(double depth_mm, double tangent, double refractive_index) {
  CheckIndex(refractive_index);
  const double q = tangent * tangent * BendOf(refractive_index);
  const double sagittal_mm = depth_mm / (1 + q / 2);
  return {sagittal_mm, sagittal_mm * (1 + q)};
}

Vec3 MiddleFocusOf(const HeadPosition& head, const ScanLens& lens,
                   double refractive_index) {
  CheckIndex(refractive_index);
  const Vec2 slopes = lens.SlopesAt(head.field_mm);
  const double q = slopes.squaredNorm() * BendOf(refractive_index);
  const Vec2 place_mm = head.field_mm + 0.5 * q * head.below_face_mm * slopes;
  return {place_mm.x(), place_mm.y(),
          refractive_index * head.below_face_mm * std::sqrt(1 + q) * (1 + q / 2)};
}

Mat3 MiddleFocusSlopes(const HeadPosition& head, const ScanLens& lens,
                       double refractive_index) {
  CheckIndex(refractive_index);
  const double n = refractive_index, k = BendOf(n), h = head.below_face_mm;
  const Vec2 t = lens.SlopesAt(head.field_mm);
  const double q = k * t.squaredNorm(), c = std::sqrt(1 + q);
  const Vec2 q_slope = (2 * k * t).cwiseQuotient(lens.pupil_mm);
  Mat3 slopes;
  slopes.topLeftCorner<2, 2>() =
      Eigen::Matrix2d::Identity() +
      0.5 * h *
          (t * q_slope.transpose() +
           Eigen::Matrix2d((q * lens.pupil_mm.cwiseInverse()).asDiagonal()));
  slopes.topRightCorner<2, 1>() = 0.5 * q * t;
  slopes.bottomLeftCorner<1, 2>() =
      n * h * ((1 + q / 2) / (2 * c) + c / 2) * q_slope.transpose();
  slopes(2, 2) = n * c * (1 + q / 2);
  return slopes;
}

std::optional<SolvedPosition> PositionFor(const Vec3& place_mm, const ScanLens& lens,
                                          double refractive_index, double tolerance_mm) {
  CheckIndex(refractive_index);
  Require(place_mm.z() >= 0, "the depth below the face must not be negative, is {}",
          place_mm.z());
  SolvedPosition solved{{place_mm.head<2>(), place_mm.z() / refractive_index}, 0};
  while (solved.steps < kMaxSteps) {
    if (!(lens.TangentAt(solved.head.field_mm) <= kMaxTangent)) return std::nullopt;
    const Vec3 wrong_mm = MiddleFocusOf(solved.head, lens, refractive_index) - place_mm;
    // Rounding leaves a few parts in 1e16 of the place.
    if (wrong_mm.norm() <= std::max(tolerance_mm, 1e-15 * place_mm.norm())) return solved;
    const Vec3 step_mm = MiddleFocusSlopes(solved.head, lens, refractive_index)
                             .partialPivLu()
                             .solve(wrong_mm);
    solved.head.field_mm -= step_mm.head<2>();
    solved.head.below_face_mm -= step_mm.z();
    ++solved.steps;
  }
  return std::nullopt;
}

}  // namespace intaglio::optics
