#include "tests/published/planar_motor.h"

#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/geometry.h"

// With the signals s = sin p + a and c = g cos(p + f) + b the angle that is read is p + d
// with, in the first order, d = a cos p - b sin p - (g - 1) sin p cos p + f sin^2 p: the
// offsets once a period, gain and phase twice; of sin^2 = (1 - cos 2p) / 2 the constant
// half is a zero of the scale and only the other half an error.

namespace intaglio::drive {
namespace {

double Phase(double x_mm, double tooth_period_mm, double third_harmonic_ratio) {
  Require(tooth_period_mm > 0, "tooth_period_mm {} must be positive", tooth_period_mm);
  Require(third_harmonic_ratio >= 0 && third_harmonic_ratio <= 0.3,
          "third_harmonic_ratio {} is outside 0..0.3", third_harmonic_ratio);
  return kTwoPi * x_mm / tooth_period_mm;
}

}  // namespace

PhaseCurrents OpenLoopCurrents(double amplitude_a, double x_mm, double tooth_period_mm,
                               double third_harmonic_ratio) {
  const double p = Phase(x_mm, tooth_period_mm, third_harmonic_ratio);
  const double k3 = third_harmonic_ratio, scale = amplitude_a / (1 + k3);
  return {scale * (std::sin(p) - k3 * std::sin(3 * p)),
          scale * (std::cos(p) + k3 * std::cos(3 * p))};
}

PhaseCurrents ClosedLoopCurrents(double current_a, double x_mm, double tooth_period_mm,
                                 double third_harmonic_ratio, double lead_rad) {
  const double p = Phase(x_mm, tooth_period_mm, third_harmonic_ratio);
  const double k3 = third_harmonic_ratio, scale = current_a / (1 - k3);
  return {scale * (std::sin(p + lead_rad) + k3 * std::sin(3 * p + lead_rad)),
          scale * (std::cos(p + lead_rad) - k3 * std::cos(3 * p + lead_rad))};
}

double IncrementalPid::Next(double error) {
  output_ += integral_ * error + proportional_ * (error - last_) +
             derivative_ * (error - 2 * last_ + before_);
  before_ = last_;
  last_ = error;
  return output_;
}

double Read(const SineCosineSensor& sensor, double x_mm) {
  Require(sensor.period_mm > 0 && sensor.division > 0 && sensor.gain_ratio > 0,
          "a sensor of {} mm, divided by {}, with a gain of {}", sensor.period_mm,
          sensor.division, sensor.gain_ratio);
  const double periods = std::floor(x_mm / sensor.period_mm);
  const double p = kTwoPi * (x_mm / sensor.period_mm - periods);
  const double sine = std::sin(p) + sensor.sine_offset_ratio;
  const double cosine = sensor.gain_ratio * std::cos(p + sensor.phase_error_rad) +
                        sensor.cosine_offset_ratio;
  // The turn that is nearest to where it is: a counter follows the crossings.
  const double read = std::atan2(sine, cosine);
  const double turned = read + kTwoPi * std::round((p - read) / kTwoPi);
  const double divided = std::round(turned / kTwoPi * sensor.division) / sensor.division;
  return sensor.period_mm * (periods + divided);
}

double InterpolationError(const SineCosineSensor& sensor) {
  return sensor.period_mm / kTwoPi *
         (std::hypot(sensor.sine_offset_ratio, sensor.cosine_offset_ratio) +
          std::abs(sensor.gain_ratio - 1) / 2 + std::abs(sensor.phase_error_rad) / 2);
}

}  // namespace intaglio::drive
