#include "engrave/galvo/head.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace intaglio::galvo {
namespace {

constexpr double kRightAngle = std::numbers::pi / 2;
constexpr int kMaxNewtonSteps = 50;

struct Height {
  double value_mm, slope_mm;  // slope: per rad
};

Height HeightAt(double t_rad, const std::array<double, 4>& f) {
  return {t_rad * (f[0] + t_rad * (f[1] + t_rad * (f[2] + t_rad * f[3]))),
          f[0] + t_rad * (2 * f[1] + t_rad * (3 * f[2] + t_rad * 4 * f[3]))};
}

/// The smallest angle of a height: Newton from below, where the slope is positive.
Result<double> ScanAngle(double height_mm, const std::array<double, 4>& f) {
  double t_rad = height_mm / f[0];
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Height at = HeightAt(t_rad, f);
    if (!(at.slope_mm > 0) || !(t_rad < kRightAngle)) break;
    const double step_rad = (at.value_mm - height_mm) / at.slope_mm;
    t_rad -= step_rad;
    if (std::abs(step_rad) <= 1e-15 + 1e-14 * t_rad) return t_rad;
  }
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("the lens has no height of {:.6g} mm; give a place nearer the centre, "
                  "or check the lens polynomial",
                  height_mm),
      fmt::format("{:.6g}", height_mm));
}

}  // namespace

Status CheckHead(const Head& head) {
  const auto fail = [](const char* name, double value, const char* remedy) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("head: {} is {}; {}", name, value, remedy),
                fmt::format("{}", value));
  };
  if (head.lens == LensPlace::kBeforeMirrors) {
    if (!(head.distance_mm > 0) || !std::isfinite(head.distance_mm))
      return fail("distance_mm", head.distance_mm, "give more than 0");
    if (!(head.mirror_gap_mm >= 0) || !std::isfinite(head.mirror_gap_mm))
      return fail("mirror_gap_mm", head.mirror_gap_mm, "give 0 or more");
    return {};
  }
  for (const double height_mm : head.heights_mm)
    if (!std::isfinite(height_mm))
      return fail("heights_mm", height_mm, "give finite numbers");
  if (!(head.heights_mm[0] > 0))
    return fail("heights_mm[0]", head.heights_mm[0], "give the focal length, above 0");
  return {};
}

Vec2 FieldOf(const Vec2& angles_rad, const Head& head) {
  const double ax = angles_rad.x(), ay = angles_rad.y();
  if (head.lens == LensPlace::kBeforeMirrors) {
    return {(head.distance_mm / std::cos(ay) + head.mirror_gap_mm) * std::tan(ax),
            head.distance_mm * std::tan(ay)};
  }
  const Vec2 across(std::sin(ax) * std::cos(ay), std::sin(ay));
  const double sine = across.norm();
  if (sine == 0) return Vec2::Zero();
  const double t_rad = std::atan2(sine, std::cos(ax) * std::cos(ay));
  return HeightAt(t_rad, head.heights_mm).value_mm / sine * across;
}

Result<Vec2> AnglesFor(const Vec2& place_mm, const Head& head) {
  if (head.lens == LensPlace::kBeforeMirrors) {
    const double ay = std::atan(place_mm.y() / head.distance_mm);
    const double way_mm = head.distance_mm / std::cos(ay) + head.mirror_gap_mm;
    return Vec2(std::atan(place_mm.x() / way_mm), ay);
  }
  const double height_mm = place_mm.norm();
  if (height_mm == 0) return Vec2(Vec2::Zero());
  const auto t_rad = ScanAngle(height_mm, head.heights_mm);
  if (!t_rad) return tl::unexpected(t_rad.error());
  const Vec2 across = std::sin(*t_rad) / height_mm * place_mm;
  return Vec2(std::atan2(across.x(), std::cos(*t_rad)), std::asin(across.y()));
}

}  // namespace intaglio::galvo
