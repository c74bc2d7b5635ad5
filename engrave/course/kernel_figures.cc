#include "engrave/course/kernel_figures.h"

#include <algorithm>
#include <cmath>

namespace intaglio::course {
namespace {

double GreatestSize(const std::vector<double>& values) {
  double greatest = 0;
  for (const double x : values) greatest = std::max(greatest, std::abs(x));
  return greatest;
}

/// The running integral.
std::vector<double> Integral(const std::vector<double>& values, double period_s) {
  std::vector<double> sums;
  double sum = 0;
  for (const double x : values) sums.push_back(sum += x * period_s);
  return sums;
}

}  // namespace

KernelFigures FiguresOf(const SplineKernel& kernel, const AxisPair& axes) {
  const double h = kernel.period_s;
  const auto weights = kernel.Weights();
  const auto half = static_cast<double>(kernel.half_count());
  KernelFigures figures;
  // Zeros on both sides, for the derivatives; as density, 1/s.
  std::vector<double> density(weights.size() + 16, 0);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    figures.rounding_s += weights[i] * std::abs(static_cast<double>(i) - half) * h / 2;
    density[i + 8] = weights[i] / h;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const auto motor = ApplyPolynomial(axes[i].mechanics(), h, density);
    figures.motor_per_speed[i] = GreatestSize(motor);
    figures.motor_per_acceleration[i] = GreatestSize(Integral(motor, h));
  }
  const double derivative[] = {0, 1};
  figures.jerk_per_speed = GreatestSize(ApplyPolynomial(derivative, h, density));
  figures.jerk_per_acceleration = GreatestSize(density);
  return figures;
}

}  // namespace intaglio::course
