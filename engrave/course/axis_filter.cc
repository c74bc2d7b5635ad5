#include "engrave/course/axis_filter.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// With d the denominator and y the actual position, d0 y + d1 y' + ... + dn y^(n) = u.
// States z_k = T^k y^(k), T = d1 for numbers of one size, time in units of T:
//   z_k' = z_(k+1),  z_(n-1)' = (u - sum d_k z_k / T^k) T^n / dn.
// u is linear within a period: two more states, u and its slope, and one exponential of
// the whole matrix gives the step.

namespace intaglio::course {
namespace {

using Matrix = Eigen::MatrixXd;

/// By its series, after halving the matrix until that converges at once.
Matrix Exponential(Matrix a) {
  int halvings = 0;
  while (a.cwiseAbs().rowwise().sum().maxCoeff() > 0.25) {
    a /= 2;
    ++halvings;
  }
  Matrix sum = Matrix::Identity(a.rows(), a.cols()), term = sum;
  constexpr int kTerms = 14;  // .25^14 / 14! is below 1e-19
  for (int i = 1; i <= kTerms; ++i) {
    term = term * a / i;
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = Matrix(sum * sum);
  return sum;
}

}  // namespace

AxisFilter::AxisFilter(std::span<const double> denominator, double period_s)
    : order_(static_cast<int>(denominator.size()) - 1), period_s_(period_s) {
  Require(order_ >= 0 && order_ <= kMaxOrder && denominator[0] == 1,
          "a denominator of {} coefficients", denominator.size());
  Require(period_s > 0, "period_s {} is not positive", period_s);
  if (order_ == 0) return;
  lag_s_ = denominator[1];
  const int n = order_;
  Matrix a = Matrix::Zero(n + 2, n + 2);
  const double last = denominator[static_cast<std::size_t>(n)] / std::pow(lag_s_, n);
  for (int k = 0; k + 1 < n; ++k) a(k, k + 1) = 1;
  for (int k = 0; k < n; ++k)
    a(n - 1, k) = -denominator[static_cast<std::size_t>(k)] / std::pow(lag_s_, k) / last;
  a(n - 1, n) = 1 / last;
  const double step = period_s / lag_s_;
  a(n, n + 1) = 1 / step;  // the slope state is the change over the period
  const Matrix e = Exponential(a * step);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) step_[i][k] = e(i, k);
    next_[i] = e(i, n + 1);
    now_[i] = e(i, n) - e(i, n + 1);
  }
}

// The order is a constant of the loops, which are the most that a plan computes.
template <int kOrder>
void AxisFilter::RunOf(std::span<const double> setpoints,
                       std::span<double> actual) const {
  // Filters the difference to the line of the first two setpoints, from rest.
  const std::size_t count = setpoints.size();
  const double slope = count > 1 ? setpoints[1] - setpoints[0] : 0;
  const double lag = lag_s_ / period_s_ * slope;
  double z[kOrder] = {}, changed[kOrder];
  double line = setpoints[0], u = 0;
  actual[0] = line - lag;
  for (std::size_t i = 1; i < count; ++i) {
    line = setpoints[0] + slope * static_cast<double>(i);
    const double u_next = setpoints[i] - line;
    for (int r = 0; r < kOrder; ++r) {
      double sum = now_[r] * u + next_[r] * u_next;
      for (int k = 0; k < kOrder; ++k) sum += step_[r][k] * z[k];
      changed[r] = sum;
    }
    for (int r = 0; r < kOrder; ++r) z[r] = changed[r];
    u = u_next;
    actual[i] = line - lag + z[0];
  }
}

void AxisFilter::Run(std::span<const double> setpoints, std::span<double> actual) const {
  if (setpoints.empty()) return;
  static_assert(kMaxOrder == 6);
  switch (order_) {
    case 1:
      return RunOf<1>(setpoints, actual);
    case 2:
      return RunOf<2>(setpoints, actual);
    case 3:
      return RunOf<3>(setpoints, actual);
    case 4:
      return RunOf<4>(setpoints, actual);
    case 5:
      return RunOf<5>(setpoints, actual);
    case 6:
      return RunOf<6>(setpoints, actual);
    default:
      std::copy(setpoints.begin(), setpoints.end(), actual.begin());
  }
}

}  // namespace intaglio::course
