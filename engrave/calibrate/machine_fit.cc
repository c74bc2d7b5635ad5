#include "engrave/calibrate/machine_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "engrave/calibrate/robust_line.h"
#include "engrave/core/try.h"

// Coordinate by coordinate a linear system: m_x = t_x + F_xx n_x + F_xy n_y - b_x d_x / 2
// - tau_x v_x. The places were made with A0, what is known of the axes, where
//   A(s_x, s_y, q) = (s_x, s_y sin q; 0, s_y cos q)
// so that axes at c had to be at n = A0 c and are at m = t + R A c, with the rotation R
// of the frame of the measurement: F A0 = R A, and A is the upper factor of its QR
// decomposition:
//   s_x = |col 0|, rotation = arg col 0, s_y = |col 1|, q = pi/2 - (arg col 1 - arg col
//   0).

namespace intaglio::calibrate {
namespace {

using Mat2 = Eigen::Matrix2d;
// Backlash and lag are along the axes of the machine: what is measured is turned to them
// by the rotation that the first fit finds.
constexpr int kTurnings = 3;
enum { kOffset, kOfX, kOfY, kBacklash, kLag, kUnknowns };

struct AxisSolution {
  RobustSolution fit;
  std::vector<std::size_t> marks;  // of each row
};

const char* RemedyOf(const std::string& unknown) {
  switch (unknown.empty() ? kOffset : unknown[0] - '0') {
    case kOfX:
    case kOfY:
      return "the marks do not extend over x and y; measure marks at the corners of the "
             "pattern";
    case kBacklash:
      return "the marks were passed in one direction; measure rows of both directions";
    case kLag:
      return "the marks were passed at one speed; measure slow and fast rows";
    default:
      return "there are too few marks; measure at least a row of each kind at three "
             "places";
  }
}

Result<AxisSolution> SolveAxis(const std::vector<PassedMark>& marks, int axis) {
  AxisSolution solution;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].direction[axis] != 0) solution.marks.push_back(i);
  }
  const auto rows = static_cast<Eigen::Index>(solution.marks.size());
  Eigen::MatrixXd a(rows, static_cast<int>(kUnknowns));
  Eigen::VectorXd b(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const PassedMark& mark = marks[solution.marks[static_cast<std::size_t>(r)]];
    a.row(r) << 1, mark.place_mm.x(), mark.place_mm.y(), -0.5 * mark.direction[axis],
        -mark.speed_mm_s[axis];
    b[r] = mark.measured_mm[axis];
  }
  auto solved = SolveRobustly(a, b);
  if (!solved) {
    return Fail(ErrorCode::kMissing, fmt::format("axis {}: {}", axis == 0 ? "x" : "y",
                                                 RemedyOf(solved.error().value)));
  }
  solution.fit = std::move(*solved);
  return solution;
}

/// s_x, s_y, q and the rotation of F A0.
Eigen::Vector4d GeometryOf(const Eigen::Vector4d& f, const Mat2& a0) {
  Mat2 m;
  m << f[0], f[1], f[2], f[3];
  m = (m * a0).eval();
  const double along_x = std::atan2(m(1, 0), m(0, 0));
  // The angle from column 0 to column 1, less a right one, near 0.
  const Vec2 y = Eigen::Rotation2Dd(-along_x) * Vec2(m.col(1));
  return {m.col(0).norm(), y.norm(), std::atan2(y.x(), y.y()), along_x};
}

/// Propagates the covariance of F, whose rows are independent, by differences.
struct Geometry {
  Eigen::Vector4d values, intervals95;
};
Geometry GeometryFrom(const AxisSolution& x, const AxisSolution& y, const Mat2& a0) {
  const Eigen::Vector4d f(x.fit.values[kOfX], x.fit.values[kOfY], y.fit.values[kOfX],
                          y.fit.values[kOfY]);
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  covariance.topLeftCorner<2, 2>() = x.fit.covariance.block<2, 2>(kOfX, kOfX);
  covariance.bottomRightCorner<2, 2>() = y.fit.covariance.block<2, 2>(kOfX, kOfX);
  constexpr double kStep = 1e-6;
  Eigen::Matrix4d derivative;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector4d step = kStep * Eigen::Vector4d::Unit(i);
    derivative.col(i) =
        (GeometryOf(f + step, a0) - GeometryOf(f - step, a0)) / (2 * kStep);
  }
  const Eigen::Matrix4d of_values = derivative * covariance * derivative.transpose();
  const double factor = Student95(std::min(x.fit.degrees, y.fit.degrees));
  return {GeometryOf(f, a0), factor * of_values.diagonal().cwiseSqrt()};
}

AxisFigures FiguresOf(const AxisSolution& axis, double scale, double scale_interval) {
  const RobustSolution& fit = axis.fit;
  const double factor = Student95(fit.degrees);
  const auto figure = [&](int unknown) {
    return Figure{fit.values[unknown],
                  factor * std::sqrt(fit.covariance(unknown, unknown))};
  };
  AxisFigures figures;
  figures.scale_ratio = {scale, scale_interval};
  figures.backlash_mm = figure(kBacklash);
  figures.lag_s = figure(kLag);
  figures.repeatability_mm = {fit.deviation,
                              factor * fit.deviation / std::sqrt(2.0 * fit.degrees)};
  figures.used_count =
      static_cast<int>(std::count(fit.used.begin(), fit.used.end(), true));
  figures.rejected_count = static_cast<int>(fit.used.size()) - figures.used_count;
  return figures;
}

void AddResiduals(const AxisSolution& solution, int axis,
                  const std::vector<PassedMark>& marks, MachineFit& fit) {
  const Eigen::VectorXd& values = solution.fit.values;
  for (const std::size_t i : solution.marks) {
    const PassedMark& mark = marks[i];
    const double fitted_mm = values[kOffset] + values[kOfX] * mark.place_mm.x() +
                             values[kOfY] * mark.place_mm.y() -
                             0.5 * values[kBacklash] * mark.direction[axis] -
                             values[kLag] * mark.speed_mm_s[axis];
    fit.residuals_mm[i][axis] = mark.measured_mm[axis] - fitted_mm;
  }
}

/// Turns what was measured back by this, so that its axes are those of the machine.
void TurnBack(double angle_rad, std::vector<PassedMark>& marks) {
  const Eigen::Rotation2Dd back(-angle_rad);
  for (PassedMark& mark : marks) mark.measured_mm = back * mark.measured_mm;
}

/// Fits marks that are turned little.
Result<MachineFit> FitTurned(const std::vector<PassedMark>& marks, const Mat2& a0) {
  const AxisSolution x = INTAGLIO_TRY(SolveAxis(marks, 0));
  const AxisSolution y = INTAGLIO_TRY(SolveAxis(marks, 1));
  const Geometry geometry = GeometryFrom(x, y, a0);
  MachineFit fit;
  fit.axes = {FiguresOf(x, geometry.values[0], geometry.intervals95[0]),
              FiguresOf(y, geometry.values[1], geometry.intervals95[1])};
  fit.squareness_rad = {geometry.values[2], geometry.intervals95[2]};
  fit.rotation_rad = geometry.values[3];
  fit.offset_mm = Vec2(x.fit.values[kOffset], y.fit.values[kOffset]);
  fit.residuals_mm.assign(marks.size(), Vec2::Zero());
  AddResiduals(x, 0, marks, fit);
  AddResiduals(y, 1, marks, fit);
  for (const PassedMark& mark : marks) {
    fit.deviations_mm.push_back(mark.measured_mm - fit.offset_mm - mark.place_mm);
  }
  return fit;
}

}  // namespace

Result<MachineFit> FitMachine(const std::vector<PassedMark>& marks,
                              const KnownGeometry& known) {
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].measured_mm.allFinite() && marks[i].place_mm.allFinite()) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("mark {} has a coordinate that is no number", i));
  }
  Mat2 a0;
  a0 << known.x_scale_ratio, known.y_scale_ratio * std::sin(known.squareness_rad), 0,
      known.y_scale_ratio * std::cos(known.squareness_rad);
  std::vector<PassedMark> turned = marks;
  double rotation_rad = 0;
  for (int round = 0; round < kTurnings; ++round) {
    const MachineFit rough = INTAGLIO_TRY(FitTurned(turned, a0));
    TurnBack(rough.rotation_rad, turned);
    rotation_rad += rough.rotation_rad;
  }
  MachineFit fit = INTAGLIO_TRY(FitTurned(turned, a0));
  fit.rotation_rad += rotation_rad;
  fit.offset_mm = Eigen::Rotation2Dd(rotation_rad) * fit.offset_mm;
  return fit;
}

}  // namespace intaglio::calibrate
