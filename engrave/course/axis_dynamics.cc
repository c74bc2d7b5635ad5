#include "engrave/course/axis_dynamics.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::course {
namespace {

constexpr double kMinRate = 0.1, kMaxRate = 1e6;  // rad/s
constexpr double kMinDampingRatio = 0.01, kMaxDampingRatio = 5;

bool IsRate(double w) {
  return (w >= kMinRate && w <= kMaxRate) || (std::isinf(w) && w > 0);
}

std::vector<double> LoopOf(const AxisParameters& p) {
  if (std::isinf(p.bandwidth_rad_s)) return {1};
  const double t = 1 / p.bandwidth_rad_s;
  if (p.loop == LoopKind::kFirstOrder) return {1, t};
  return {1, t, t * t / 3, t * t * t / 36};
}

std::vector<double> MechanicsOf(const AxisParameters& p) {
  if (std::isinf(p.natural_rad_s)) return {1};
  const double tau = 1 / p.natural_rad_s;
  return {1, 2 * p.damping_ratio * tau, tau * tau};
}

std::vector<double> Product(const std::vector<double>& p, const std::vector<double>& q) {
  std::vector<double> r(p.size() + q.size() - 1, 0);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t k = 0; k < q.size(); ++k) r[i + k] += p[i] * q[k];
  return r;
}

/// The roots as eigenvalues of the companion matrix, in units of the polynomial's own
/// rate so that its coefficients are of one size.
std::vector<std::complex<double>> RootsOf(const std::vector<double>& p) {
  const auto n = static_cast<Eigen::Index>(p.size()) - 1;
  if (n < 1) return {};
  const double rate = std::pow(1 / std::abs(p.back()), 1.0 / static_cast<double>(n));
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i + 1 < n) companion(i + 1, i) = 1;
    companion(i, n - 1) = -p[static_cast<std::size_t>(i)] *
                          std::pow(rate, static_cast<double>(i)) /
                          (p.back() * std::pow(rate, static_cast<double>(n)));
  }
  const Eigen::VectorXcd roots =
      Eigen::EigenSolver<Eigen::MatrixXd>(companion, false).eigenvalues();
  std::vector<std::complex<double>> poles;
  for (Eigen::Index i = 0; i < n; ++i) poles.push_back(roots[i] * rate);
  return poles;
}

constexpr double kApart = 1e-6;

void MoveApart(std::vector<std::complex<double>>& poles) {
  for (std::size_t i = 0; i < poles.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (std::abs(poles[i] - poles[k]) < kApart / 10 * std::abs(poles[i]))
        poles[i] *= 1 + kApart;
    }
  }
}

}  // namespace

AxisDynamics::AxisDynamics(const AxisParameters& parameters) : parameters_(parameters) {
  Require(IsRate(parameters.bandwidth_rad_s), "bandwidth_rad_s {} is outside {}..{}",
          parameters.bandwidth_rad_s, kMinRate, kMaxRate);
  Require(IsRate(parameters.natural_rad_s), "natural_rad_s {} is outside {}..{}",
          parameters.natural_rad_s, kMinRate, kMaxRate);
  Require(std::isinf(parameters.natural_rad_s) ||
              (parameters.damping_ratio >= kMinDampingRatio &&
               parameters.damping_ratio <= kMaxDampingRatio),
          "damping_ratio {} is outside {}..{}", parameters.damping_ratio,
          kMinDampingRatio, kMaxDampingRatio);
  loop_ = LoopOf(parameters);
  mechanics_ = MechanicsOf(parameters);
  product_ = Product(loop_, mechanics_);
  poles_ = RootsOf(product_);
  MoveApart(poles_);
}

AxisDynamics AxisDynamics::WithMechanics(double frequency_ratio,
                                         double damping_ratio) const {
  AxisParameters changed = parameters_;
  changed.natural_rad_s *= frequency_ratio;
  changed.damping_ratio *= damping_ratio;
  return AxisDynamics(changed);
}

double CommonBandwidth(double natural_1_rad_s, double natural_2_rad_s) {
  return natural_1_rad_s * natural_2_rad_s / std::hypot(natural_1_rad_s, natural_2_rad_s);
}

AxisPair TunedAxes(double natural_1_rad_s, double natural_2_rad_s, double damping_1_ratio,
                   double damping_2_ratio, LoopKind loop) {
  const double bandwidth = CommonBandwidth(natural_1_rad_s, natural_2_rad_s);
  return {AxisDynamics({loop, bandwidth, natural_1_rad_s, damping_1_ratio}),
          AxisDynamics({loop, bandwidth, natural_2_rad_s, damping_2_ratio})};
}

}  // namespace intaglio::course
