// The centre of smallest squares of sum (|p_k - c| - r)^2, by Gauss and Newton from the
// algebraic circle (Kasa 1976): residual |p_k - c| - r, slopes -(p_k - c) / |p_k - c| of
// c and -1 of r.

#include "engrave/calibrate/circle_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"

namespace intaglio::calibrate {
namespace {

constexpr std::size_t kMinPoints = 8;
constexpr double kMaxGapRad = std::numbers::pi / 2;
constexpr int kMaxSteps = 50;
constexpr double kSolvedMm = 1e-12;

Status CheckPoints(std::span<const Vec2> points_mm, double radius_mm) {
  if (!(radius_mm > 0) || !std::isfinite(radius_mm)) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a radius of {} mm; give that of the commanded circle, above 0",
                    radius_mm));
  }
  if (points_mm.size() < kMinPoints) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{} {} too few for a circle; measure {} or more, all "
                            "around",
                            Counted(points_mm.size(), "point"), IsOrAre(points_mm.size()),
                            kMinPoints),
                fmt::format("{}", points_mm.size()));
  }
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    if (points_mm[i].allFinite()) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("point {} has a coordinate that is no number", i + 1));
  }
  return {};
}

/// x, y, r of the algebraic circle about the mean of the points; not finite on a line.
Eigen::Vector3d AlgebraicCircle(std::span<const Vec2> points_mm, const Vec2& mean_mm) {
  const auto count = static_cast<Eigen::Index>(points_mm.size());
  Eigen::MatrixXd left(count, 3);
  Eigen::VectorXd right(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vec2 p = points_mm[static_cast<std::size_t>(k)] - mean_mm;
    left.row(k) << 2 * p.x(), 2 * p.y(), 1;
    right(k) = p.squaredNorm();
  }
  const auto solver = left.colPivHouseholderQr();
  if (solver.rank() < 3) return Eigen::Vector3d::Constant(std::nan(""));
  const Eigen::Vector3d c = solver.solve(right);
  return {c.x() + mean_mm.x(), c.y() + mean_mm.y(),
          std::sqrt(c.z() + c.head<2>().squaredNorm())};
}

Result<Eigen::Vector3d> FitCircle(std::span<const Vec2> points_mm) {
  Vec2 mean_mm = Vec2::Zero();
  for (const Vec2& p : points_mm) mean_mm += p / static_cast<double>(points_mm.size());
  Eigen::Vector3d circle = AlgebraicCircle(points_mm, mean_mm);
  for (int i = 0; i < kMaxSteps && circle.allFinite(); ++i) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Vec2& p : points_mm) {
      const Vec2 out = p - circle.head<2>();
      const double r = out.norm();
      const Eigen::Vector3d slope(out.x() / r, out.y() / r, 1);
      normal += slope * slope.transpose();
      right += (r - circle.z()) * slope;
    }
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    circle += step;
    if (step.norm() < kSolvedMm * std::max(1.0, circle.z())) return circle;
  }
  if (circle.allFinite()) return circle;
  return Fail(ErrorCode::kInvalidValue,
              "the points lie on no circle; check the columns of the table");
}

double LargestGap(std::vector<double> angles_rad) {
  std::ranges::sort(angles_rad);
  double gap_rad = angles_rad.front() + 2 * std::numbers::pi - angles_rad.back();
  for (std::size_t i = 1; i < angles_rad.size(); ++i)
    gap_rad = std::max(gap_rad, angles_rad[i] - angles_rad[i - 1]);
  return gap_rad;
}

/// r0, a, b of smallest squares.
Eigen::Vector3d SecondHarmonic(const std::vector<double>& radii_mm,
                               const std::vector<double>& angles_rad) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < radii_mm.size(); ++k) {
    const Eigen::Vector3d row(1, std::cos(2 * angles_rad[k]),
                              std::sin(2 * angles_rad[k]));
    normal += row * row.transpose();
    right += radii_mm[k] * row;
  }
  return normal.ldlt().solve(right);
}

}  // namespace

Result<CircleCheck> CheckCircle(std::span<const Vec2> points_mm, double radius_mm,
                                const std::optional<Vec2>& centre_mm) {
  INTAGLIO_TRY(CheckPoints(points_mm, radius_mm));
  const Eigen::Vector3d circle = INTAGLIO_TRY(FitCircle(points_mm));
  CircleCheck check;
  check.centre_mm = circle.head<2>();
  check.radius_mm = circle.z();
  std::vector<double> radii_mm, angles_rad, radial_mm;
  for (const Vec2& p : points_mm) {
    const Vec2 out = p - check.centre_mm;
    radii_mm.push_back(out.norm());
    angles_rad.push_back(std::atan2(out.y(), out.x()));
    radial_mm.push_back((p - centre_mm.value_or(check.centre_mm)).norm() - radius_mm);
  }
  check.gap_rad = LargestGap(angles_rad);
  if (check.gap_rad > kMaxGapRad) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("the points leave a gap of {:.0f} degrees; measure all around",
                    check.gap_rad * 180 / std::numbers::pi));
  }
  const auto [low, high] = std::ranges::minmax(radii_mm);
  check.circular_deviation_mm = high - low;
  const auto [low_radial, high_radial] = std::ranges::minmax(radial_mm);
  check.min_radial_mm = low_radial;
  check.max_radial_mm = high_radial;
  const Eigen::Vector3d wave = SecondHarmonic(radii_mm, angles_rad);
  check.scale_ratio = 2 * wave.y() / radius_mm;
  check.squareness_rad = 2 * wave.z() / radius_mm;
  for (std::size_t k = 0; k < radii_mm.size(); ++k) {
    radii_mm[k] -= wave.dot(
        Eigen::Vector3d(1, std::cos(2 * angles_rad[k]), std::sin(2 * angles_rad[k])));
  }
  const auto [low_rest, high_rest] = std::ranges::minmax(radii_mm);
  check.rest_mm = high_rest - low_rest;
  return check;
}

}  // namespace intaglio::calibrate
