#include "engrave/drive/sampled_axis.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

// Over a time t with constant voltage, V = g U - tau (load + friction) is the speed that
// the axis comes to: with E = exp(-t / tau)
//   v(t) = V + (v - V) E,   x(t) = x + V t + (v - V) tau (1 - E).
// Friction acts against the motion; where v passes through zero within a period, at t =
// tau ln(1 - v / V), the axis stands there and goes on only if the voltage overcomes the
// friction.
//
// The loop without quantization is linear in (x, v, x before): with r = 0 the sample n
// gives U = -(p + d / T) x + d / T x before.

namespace intaglio::drive {
namespace {

constexpr double kShortestPeriodS = 1e-7;
constexpr double kLongestPeriodS = 10;

double SpectralRadius(const SampledAxis& axis, double period_s) {
  const double tau = axis.velocity_time_s, g = axis.speed_per_volt;
  const double left = std::exp(-period_s / tau);
  const double moved = tau * -std::expm1(-period_s / tau);
  const double by_x = -(axis.loop.volt_per_m + axis.loop.volt_s_per_m / period_s) * g;
  const double by_before = axis.loop.volt_s_per_m / period_s * g;
  Eigen::Matrix3d step;
  step << 1 + by_x * (period_s - moved), moved, by_before * (period_s - moved),
      by_x * (1 - left), left, by_before * (1 - left),  //
      1, 0, 0;
  return step.eigenvalues().cwiseAbs().maxCoeff();
}

void Check(const SampledAxis& axis) {
  Require(axis.speed_per_volt > 0 && axis.velocity_time_s > 0 && axis.period_s > 0,
          "an axis of {} m/s per V, {} s, sampled every {} s", axis.speed_per_volt,
          axis.velocity_time_s, axis.period_s);
  Require(axis.loop.volt_per_m > 0 && axis.loop.volt_s_per_m >= 0,
          "gains of {} V/m and {} V s/m", axis.loop.volt_per_m, axis.loop.volt_s_per_m);
  Require(axis.volt_per_step.value_or(1) > 0 && axis.max_volt.value_or(1) > 0 &&
              axis.counts_per_m.value_or(1) > 0 && axis.friction_m_s2 >= 0,
          "{} V a step, {} V, {} counts per m, friction {} m/s^2",
          axis.volt_per_step.value_or(1), axis.max_volt.value_or(1),
          axis.counts_per_m.value_or(1), axis.friction_m_s2);
}

/// One axis between two samples.
class Plant {
 public:
  Plant(const SampledAxis& axis, double at_m) : axis_(axis), x_m_(at_m) {}

  double x_m() const { return x_m_; }
  double v_m_s() const { return v_m_s_; }
  /// With this voltage, from now on; friction where it moves, else what it can hold.
  double Acceleration(double volt) const {
    return (Towards(volt, Sign(volt)) - v_m_s_) / axis_.velocity_time_s;
  }

  void Hold(double volt, double left_s) {
    while (left_s > 0) {
      const double sign = Sign(volt);
      if (sign == 0 && axis_.friction_m_s2 > 0) return;  // it is held
      const double towards = Towards(volt, sign);
      double step_s = left_s;
      if (v_m_s_ * towards < 0 && axis_.friction_m_s2 > 0) {
        const double to_rest_s = axis_.velocity_time_s * std::log1p(-v_m_s_ / towards);
        step_s = std::min(step_s, to_rest_s);
      }
      Move(towards, step_s);
      if (step_s < left_s) v_m_s_ = 0;
      left_s -= step_s;
    }
  }

 private:
  void Move(double towards, double t_s) {
    const double tau = axis_.velocity_time_s;
    const double gone = -std::expm1(-t_s / tau);
    x_m_ += towards * t_s + (v_m_s_ - towards) * tau * gone;
    v_m_s_ += (towards - v_m_s_) * gone;
  }
  double Towards(double volt, double sign) const {
    return axis_.speed_per_volt * volt -
           axis_.velocity_time_s * (axis_.load_m_s2 + sign * axis_.friction_m_s2);
  }
  /// Which way it moves, or will; 0: it rests and is held.
  double Sign(double volt) const {
    if (v_m_s_ != 0) return std::copysign(1.0, v_m_s_);
    const double pull = Towards(volt, 0) / axis_.velocity_time_s;
    if (std::abs(pull) <= axis_.friction_m_s2) return 0;
    return std::copysign(1.0, pull);
  }

  const SampledAxis& axis_;
  double x_m_, v_m_s_ = 0;
};

class Controller {
 public:
  Controller(const SampledAxis& axis, double at_m)
      : axis_(axis), setpoint_before_m_(at_m) {}

  double Volt(double setpoint_m, double x_m) {
    const double read_m =
        axis_.counts_per_m ? std::round(x_m * *axis_.counts_per_m) / *axis_.counts_per_m
                           : x_m;
    const double error_m = setpoint_m - read_m;
    const double change_m = setpoint_m - setpoint_before_m_;
    double volt = axis_.loop.volt_per_m * error_m +
                  axis_.loop.volt_s_per_m * (error_m - error_before_m_) / axis_.period_s +
                  axis_.loop.feed_forward_ratio * change_m /
                      (axis_.speed_per_volt * axis_.period_s);
    error_before_m_ = error_m;
    setpoint_before_m_ = setpoint_m;
    if (axis_.volt_per_step)
      volt = *axis_.volt_per_step * std::round(volt / *axis_.volt_per_step);
    if (axis_.max_volt) volt = std::clamp(volt, -*axis_.max_volt, *axis_.max_volt);
    return volt;
  }

 private:
  const SampledAxis& axis_;
  double setpoint_before_m_, error_before_m_ = 0;
};

}  // namespace

double LargestStablePeriod(const SampledAxis& axis) {
  const auto stable = [&](double period_s) { return SpectralRadius(axis, period_s) < 1; };
  if (!stable(kShortestPeriodS)) return 0;
  double low_s = kShortestPeriodS, high_s = low_s;
  while (stable(high_s)) {
    low_s = high_s;
    high_s *= 1.05;
    if (high_s > kLongestPeriodS) return kLongestPeriodS;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle_s = 0.5 * (low_s + high_s);
    (stable(middle_s) ? low_s : high_s) = middle_s;
  }
  return low_s;
}

Result<std::vector<AxisSample>> Simulate(const SampledAxis& axis,
                                         std::span<const double> setpoints_m) {
  Check(axis);
  if (SpectralRadius(axis, axis.period_s) >= 1) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the loop is not stable with a period of {:.4g} s; the "
                            "largest stable one is {:.4g} s: sample faster or lower the "
                            "gains",
                            axis.period_s, LargestStablePeriod(axis)),
                fmt::format("{}", axis.period_s));
  }
  std::vector<AxisSample> samples;
  if (setpoints_m.empty()) return samples;
  samples.reserve(setpoints_m.size());
  Plant plant(axis, setpoints_m.front());
  Controller controller(axis, setpoints_m.front());
  for (const double setpoint_m : setpoints_m) {
    AxisSample sample{plant.x_m(), plant.v_m_s()};
    sample.volt = controller.Volt(setpoint_m, plant.x_m());
    sample.acceleration_m_s2 = plant.Acceleration(sample.volt);
    sample.following_error_m = setpoint_m - plant.x_m();
    samples.push_back(sample);
    plant.Hold(sample.volt, axis.period_s);
  }
  return samples;
}

}  // namespace intaglio::drive
