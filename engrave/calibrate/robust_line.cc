#include "engrave/calibrate/robust_line.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "engrave/calibrate/median.h"

// Start: iteratively weighted least squares with Huber's weights min(1, k s / |r|), s
// from the median of |r|. Then rows within five deviations are solved with equal weights,
// until the same rows are used twice; of normal errors one in two million is left out, so
// the deviation and the covariance are those of ordinary least squares.

namespace intaglio::calibrate {
namespace {

constexpr double kHuber = 1.345;
constexpr double kOutlier = 5;
constexpr int kMaxRounds = 30;
// Below it a column is a combination of the others but for rounding.
constexpr double kRank = 1e-7;
// A residual below this is rounding: exact measurements have no outliers.
constexpr double kRoundingShare = 1e-12;

double MadOf(const Eigen::VectorXd& residuals) {
  std::vector<double> sizes(residuals.size());
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    sizes[static_cast<std::size_t>(i)] = std::abs(residuals[i]);
  }
  return kNormalMad * MedianOf(sizes);
}

Eigen::VectorXd SolveWeighted(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                              const Eigen::VectorXd& weights) {
  const Eigen::VectorXd roots = weights.cwiseSqrt();
  return (roots.asDiagonal() * a)
      .colPivHouseholderQr()
      .solve(roots.cwiseProduct(b).eval());
}

/// The unknown that the rows do not determine; -1: they determine all.
int UndeterminedBy(const Eigen::MatrixXd& a) {
  if (a.rows() < a.cols() + 3) return 0;
  Eigen::MatrixXd unit = a;
  for (Eigen::Index c = 0; c < a.cols(); ++c) {
    const double norm = unit.col(c).norm();
    if (norm == 0) return static_cast<int>(c);
    unit.col(c) /= norm;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(unit);
  const auto diagonal = qr.matrixR().diagonal().cwiseAbs().eval();
  for (Eigen::Index k = 0; k < a.cols(); ++k) {
    if (diagonal[k] < kRank * diagonal[0])
      return static_cast<int>(qr.colsPermutation().indices()[k]);
  }
  return -1;
}

}  // namespace

Result<RobustSolution> SolveRobustly(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const auto undetermined = [](int unknown) {
    return Fail(ErrorCode::kMissing, "the measurements do not determine an unknown",
                std::to_string(unknown));
  };
  if (const int unknown = UndeterminedBy(a); unknown >= 0) return undetermined(unknown);
  const double rounding = kRoundingShare * (1 + b.cwiseAbs().maxCoeff());
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(a.rows());
  Eigen::VectorXd x = SolveWeighted(a, b, weights);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::VectorXd residuals = b - a * x;
    const double scale = std::max(MadOf(residuals), rounding);
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      weights[i] =
          std::min(1.0, kHuber * scale / std::max(std::abs(residuals[i]), scale * 1e-9));
    }
    x = SolveWeighted(a, b, weights);
  }
  RobustSolution solution;
  double deviation = std::max(MadOf(b - a * x), rounding);
  solution.used.assign(static_cast<std::size_t>(a.rows()), false);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Eigen::VectorXd residuals = b - a * x;
    std::vector<bool> used(solution.used.size());
    for (std::size_t i = 0; i < used.size(); ++i) {
      used[i] = std::abs(residuals[static_cast<Eigen::Index>(i)]) <= kOutlier * deviation;
      weights[static_cast<Eigen::Index>(i)] = used[i] ? 1 : 0;
    }
    if (used == solution.used) break;
    solution.used = used;
    const auto rows = static_cast<int>(weights.sum());
    if (rows < a.cols() + 3) return undetermined(0);
    x = SolveWeighted(a, b, weights);
    solution.degrees = rows - static_cast<int>(a.cols());
    const double squares = weights.cwiseProduct((b - a * x).cwiseAbs2()).sum();
    deviation = std::max(std::sqrt(squares / solution.degrees), rounding);
  }
  const Eigen::MatrixXd kept = weights.asDiagonal() * a;
  if (const int unknown = UndeterminedBy(kept); unknown >= 0)
    return undetermined(unknown);
  solution.values = x;
  solution.deviation = deviation;
  solution.covariance = deviation * deviation * (kept.transpose() * kept).inverse();
  return solution;
}

double Student95(int degrees) {
  constexpr double kZ = 1.959963984540054;
  const double z3 = kZ * kZ * kZ, z5 = z3 * kZ * kZ, n = degrees;
  return kZ + (z3 + kZ) / (4 * n) + (5 * z5 + 16 * z3 + 3 * kZ) / (96 * n * n);
}

}  // namespace intaglio::calibrate
