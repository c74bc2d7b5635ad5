#include "engrave/galvo/residual_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::galvo {
namespace {

// This share of the largest diagonal holds weights that no vector determines.
constexpr double kRidge = 1e-9;

struct CellBasis {
  int first;  // of the four weights along an axis
  std::array<double, 4> share;
};

CellBasis BasisOf(double place_mm, double width_mm, int cells) {
  const double x = std::clamp((place_mm / width_mm + 0.5) * cells, 0.0, 1.0 * cells);
  const int cell = std::min(static_cast<int>(x), cells - 1);
  const double t = x - cell, s = 1 - t;
  return {cell,
          {s * s * s / 6, (4 - 3 * t * t * (2 - t)) / 6, (4 - 3 * s * s * (2 - s)) / 6,
           t * t * t / 6}};
}

/// Calls `take(weight index, share)` for the sixteen weights of a place.
template <typename Take>
void ForEachWeight(const Vec2& place_mm, double width_mm, int cells, const Take& take) {
  const CellBasis x = BasisOf(place_mm.x(), width_mm, cells);
  const CellBasis y = BasisOf(place_mm.y(), width_mm, cells);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      take((y.first + j) * (cells + 3) + x.first + i,
           y.share[static_cast<std::size_t>(j)] * x.share[static_cast<std::size_t>(i)]);
    }
  }
}

}  // namespace

ResidualSurface::ResidualSurface(std::span<const PlacedVector> vectors, double width_mm,
                                 int cells)
    : width_mm_(width_mm), cells_(cells) {
  Require(width_mm > 0 && cells >= 1, "a surface of {} cells over {} mm", cells,
          width_mm);
  const int count = WeightCount(cells);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::Matrix<double, Eigen::Dynamic, 2> right =
      Eigen::Matrix<double, Eigen::Dynamic, 2>::Zero(count, 2);
  for (const PlacedVector& v : vectors) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(count);
    ForEachWeight(v.place_mm, width_mm, cells,
                  [&row](int weight, double share) { row[weight] = share; });
    normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
    right += row * v.value_mm.transpose();
  }
  normal.diagonal().array() += kRidge * std::max(normal.diagonal().maxCoeff(), 1e-30);
  weights_mm_ = normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
}

Vec2 ResidualSurface::At(const Vec2& place_mm) const {
  Vec2 sum = Vec2::Zero();
  ForEachWeight(place_mm, width_mm_, cells_, [&](int weight, double share) {
    sum += share * weights_mm_.row(weight).transpose();
  });
  return sum;
}

}  // namespace intaglio::galvo
