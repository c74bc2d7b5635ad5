#include "engrave/galvo/correction_table.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/try.h"

// The spline on uniform nodes: value at node i is (c[i-1] + 4 c[i] + c[i+1]) / 6. The
// third derivative on [i, i+1] is -c[i-1] + 3 c[i] - 3 c[i+1] + c[i+2]; that two
// neighbouring ones are equal says that the fourth difference of c is 0.

namespace intaglio::galvo {
namespace {

constexpr int kMinSplineNodes = 4;
constexpr int kMaxSolveSteps = 100;
constexpr double kSolvedMm = 1e-10;

/// Row k: the equation of c[k - 1]; solves for nodes + 2 weights.
Eigen::MatrixXd SplineEquations(int nodes) {
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(nodes + 2, nodes + 2);
  const Eigen::RowVectorXd fourth = (Eigen::RowVectorXd(5) << 1, -4, 6, -4, 1).finished();
  equations.block(0, 0, 1, 5) = fourth;
  for (int i = 0; i < nodes; ++i) {
    equations(i + 1, i) = equations(i + 1, i + 2) = 1.0 / 6;
    equations(i + 1, i + 1) = 4.0 / 6;
  }
  equations.block(nodes + 1, nodes - 3, 1, 5) = fourth;
  return equations;
}

std::vector<Vec2> SplineWeights(const FieldGrid& grid) {
  const int n = grid.nodes;
  const Eigen::PartialPivLU<Eigen::MatrixXd> solver(SplineEquations(n));
  std::vector<Vec2> weights(static_cast<std::size_t>(n + 2) *
                            static_cast<std::size_t>(n + 2));
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(n + 2, n);  // (j + 1, i)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        values(j + 1, i) = grid.values_mm[grid.IndexOf(i, j)][axis];
    const Eigen::MatrixXd columns = solver.solve(values);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n + 2, n + 2);  // (i + 1, j)
    rows.middleRows(1, n) = columns.transpose();
    const Eigen::MatrixXd both = solver.solve(rows);  // (i, j)
    for (int j = 0; j < n + 2; ++j) {
      for (int i = 0; i < n + 2; ++i)
        weights[static_cast<std::size_t>(j * (n + 2) + i)][axis] = both(i, j);
    }
  }
  return weights;
}

struct Basis {
  double a, b, c, d;
};

Basis BasisAt(double t) {
  const double s = 1 - t, tt = t * t, ss = s * s;
  return {ss * s / 6, (4 - 3 * tt * (2 - t)) / 6, (4 - 3 * ss * (2 - s)) / 6, tt * t / 6};
}

}  // namespace

Result<CorrectionTable> CorrectionTable::Make(FieldGrid grid,
                                              Interpolation interpolation) {
  INTAGLIO_TRY(CheckGrid(grid));
  if (interpolation == Interpolation::kSpline && grid.nodes < kMinSplineNodes) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a spline through {} nodes a side; give {} or more, or "
                            "interpolate bilinear",
                            grid.nodes, kMinSplineNodes),
                fmt::format("{}", grid.nodes));
  }
  return CorrectionTable(std::move(grid), interpolation);
}

CorrectionTable::CorrectionTable(FieldGrid grid, Interpolation interpolation)
    : grid_(std::move(grid)), interpolation_(interpolation), per_mm_(1 / grid_.pitch_mm) {
  if (interpolation_ == Interpolation::kSpline) weights_mm_ = SplineWeights(grid_);
}

Vec2 CorrectionTable::SplineAt(int i, int j, double u, double v) const {
  const Basis x = BasisAt(u), y = BasisAt(v);
  const int width = grid_.nodes + 2;
  const Vec2* row = weights_mm_.data() + static_cast<std::ptrdiff_t>(j) * width + i;
  const auto along = [&x](const Vec2* c) {
    return Vec2(x.a * c[0] + x.b * c[1] + x.c * c[2] + x.d * c[3]);
  };
  return y.a * along(row) + y.b * along(row + width) + y.c * along(row + 2 * width) +
         y.d * along(row + 3 * width);
}

Vec2 CorrectionTable::At(const Vec2& place_mm) const {
  const double end = grid_.nodes - 1;
  // Whatever is not above 0, also what is no number, is the border.
  const auto inside = [end](double x) { return x > 0 ? std::min(x, end) : 0.0; };
  const double x = inside((place_mm.x() - grid_.first_mm) * per_mm_);
  const double y = inside((place_mm.y() - grid_.first_mm) * per_mm_);
  const int i = std::min(static_cast<int>(x), grid_.nodes - 2);
  const int j = std::min(static_cast<int>(y), grid_.nodes - 2);
  const double u = x - i, v = y - j;
  if (interpolation_ == Interpolation::kSpline) return SplineAt(i, j, u, v);
  const Vec2* low = grid_.values_mm.data() + grid_.IndexOf(i, j);
  const Vec2 &a = low[0], &b = low[1], &c = low[grid_.nodes], &d = low[grid_.nodes + 1];
  if (interpolation_ == Interpolation::kBilinear)
    return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
  const Vec2 mean = (a + b + c + d) / 4;
  if (u + v <= 1) {
    return v < u ? Vec2((1 - u - v) * a + (u - v) * b + 2 * v * mean)
                 : Vec2((1 - u - v) * a + (v - u) * c + 2 * u * mean);
  }
  return u <= v ? Vec2((u + v - 1) * d + (v - u) * c + 2 * (1 - v) * mean)
                : Vec2((u + v - 1) * d + (u - v) * b + 2 * (1 - u) * mean);
}

// Commands near the border arrive inside it.
Vec2 ContinuedAt(const CorrectionTable& table, const Vec2& place_mm) {
  const FieldGrid& grid = table.grid();
  const double last_mm = grid.first_mm + grid.pitch_mm * (grid.nodes - 1);
  const Vec2 border_mm = place_mm.cwiseMax(grid.first_mm).cwiseMin(last_mm);
  if (border_mm == place_mm) return table.At(place_mm);
  return 2 * table.At(border_mm) - table.At(2 * border_mm - place_mm);
}

Result<Vec2> CommandFor(const Vec2& target_mm, const CorrectionTable& deviations) {
  Vec2 command_mm = target_mm;
  for (int i = 0; i < kMaxSolveSteps; ++i) {
    const Vec2 next_mm = target_mm - ContinuedAt(deviations, command_mm);
    const double step_mm = (next_mm - command_mm).norm();
    command_mm = next_mm;
    if (step_mm < kSolvedMm) return command_mm;
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("the deviations near ({:.4g}, {:.4g}) mm change as fast as the "
                          "place; check the measured grid there",
                          target_mm.x(), target_mm.y()));
}

Result<FieldGrid> CommandGrid(const CorrectionTable& deviations, int nodes) {
  const FieldGrid& of = deviations.grid();
  const double width_mm = of.pitch_mm * (of.nodes - 1);
  FieldGrid grid = CentredGrid(width_mm, nodes);
  grid.first_mm = of.first_mm;
  for (int j = 0; j < nodes; ++j) {
    for (int i = 0; i < nodes; ++i) {
      const Vec2 target_mm = grid.PlaceOf(i, j);
      const Vec2 command_mm = INTAGLIO_TRY(CommandFor(target_mm, deviations));
      grid.values_mm[grid.IndexOf(i, j)] = command_mm - target_mm;
    }
  }
  return grid;
}

}  // namespace intaglio::galvo
