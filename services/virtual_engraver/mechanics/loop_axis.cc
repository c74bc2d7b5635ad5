#include "services/virtual_engraver/mechanics/loop_axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace intaglio::virtual_engraver {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

// At 80 mm/s a tooth of 0.64 mm lasts 8 ms: 160 steps.
constexpr double kLongestStepS = 50e-6;
// Share of the fastest time constant, which FastestRate bounds: the error of a step is
// below its fifth power over 120, 1e-5 of what decays fastest.
constexpr double kStepRatio = 0.25;
// An axis that is slower and nearer than 1 pm on a constant command stays.
constexpr double kRestMmS = 1e-9, kRestMmS2 = 1e-6;

// In such a field no stage gets so far from its command that the sine counts.
constexpr double kLongStepMm = 1000;

constexpr double kDivision = 4096;  // of the sensor's period

/// A bound of the fastest rate of the equation, 1/s.
double FastestRate(const ServoOptions& o) {
  return std::max(std::sqrt(o.position_gain_per_s / o.velocity_time_s),
                  (1 + o.derivative_ratio) / o.velocity_time_s);
}
double FastestRate(const CascadeOptions& o) {
  const double mechanics = kTwoPi * o.natural_frequency_hz;
  return std::max(12 * o.position_gain_per_s, mechanics * (1 + 2 * o.damping_ratio));
}
double FastestRate(const StepperOptions& o) {
  const double p = kTwoPi * o.rotor_frequency_hz, q = kTwoPi * o.carriage_frequency_hz;
  const double both = 1 + o.inertia_ratio;
  return p * (1 + 2 * o.rotor_damping_ratio) +
         q * (std::sqrt(both) + 2 * o.carriage_damping_ratio * both);
}
double FastestRate(const PlanarOptions& o) {
  return std::sqrt(o.cogging_mm_s2 * kTwoPi / o.tooth_period_mm);
}

}  // namespace

LoopOptions Undisturbed(LoopOptions options) {
  if (auto* servo = std::get_if<ServoOptions>(&options)) {
    servo->load_mm_s2 = servo->friction_mm_s2 = 0;
    servo->max_acceleration_mm_s2 = std::numeric_limits<double>::infinity();
  } else if (auto* stepper = std::get_if<StepperOptions>(&options)) {
    stepper->full_step_mm = kLongStepMm;
  } else if (auto* planar = std::get_if<PlanarOptions>(&options)) {
    planar->cogging_mm_s2 = planar->sensor_error_mm = 0;
  }
  return options;
}

LoopAxis::LoopAxis(const LoopOptions& options, double at)
    : options_(options),
      longest_step_s_(std::visit(
          [](const auto& o) {
            return std::min(kLongestStepS, kStepRatio / std::max(1.0, FastestRate(o)));
          },
          options)) {
  state_[0] = at;
  Rest();
}

void LoopAxis::Rest() {
  state_ = {state_[0], 0, state_[0], 0, 0};
  held_mm_s2_ = last_error_ = error_before_ = 0;
}

double LoopAxis::velocity_lag_s() const {
  if (const auto* servo = std::get_if<ServoOptions>(&options_))
    return (1 - servo->feed_forward_ratio) / servo->position_gain_per_s;
  if (const auto* cascade = std::get_if<CascadeOptions>(&options_))
    return 1 / cascade->position_gain_per_s +
           2 * cascade->damping_ratio / (kTwoPi * cascade->natural_frequency_hz);
  if (const auto* stepper = std::get_if<StepperOptions>(&options_))
    return 2 * stepper->rotor_damping_ratio / (kTwoPi * stepper->rotor_frequency_hz);
  return 0;  // the integrator leaves nothing at constant speed
}

double LoopAxis::MotorAcceleration(const ServoOptions& o, const State& at, double c,
                                   double c_s) const {
  const double speed = o.position_gain_per_s * (c - at[0]) +
                       o.derivative_ratio * (c_s - at[1]) + o.feed_forward_ratio * c_s;
  return std::clamp((speed - at[1]) / o.velocity_time_s, -o.max_acceleration_mm_s2,
                    o.max_acceleration_mm_s2);
}

LoopAxis::State LoopAxis::SlopeOf(const ServoOptions& o, const State& at, double c,
                                  double c_s) const {
  return {at[1], MotorAcceleration(o, at, c, c_s) - o.load_mm_s2 -
                     friction_sign_ * o.friction_mm_s2};
}

LoopAxis::State LoopAxis::SlopeOf(const CascadeOptions& o, const State& at, double c,
                                  double) const {
  const double gain = o.position_gain_per_s, m = kTwoPi * o.natural_frequency_hz;
  const double asked_speed = gain * (c - at[2]);
  const double asked_acceleration = 3 * gain * (asked_speed - at[3]);
  return {at[1], m * m * (at[2] - at[0]) - 2 * o.damping_ratio * m * at[1], at[3], at[4],
          12 * gain * (asked_acceleration - at[4])};
}

LoopAxis::State LoopAxis::SlopeOf(const StepperOptions& o, const State& at, double c,
                                  double) const {
  const double p = kTwoPi * o.rotor_frequency_hz, q = kTwoPi * o.carriage_frequency_hz;
  const double per_field = kTwoPi / (4 * o.full_step_mm);
  const double field = p * p * std::sin(per_field * (c - at[2])) / per_field;
  const double taken =
      q * q * (at[2] - at[0]) + 2 * o.carriage_damping_ratio * q * (at[3] - at[1]);
  return {at[1], taken, at[3],
          field - 2 * o.rotor_damping_ratio * p * at[3] - o.inertia_ratio * taken};
}

LoopAxis::State LoopAxis::SlopeOf(const PlanarOptions& o, const State& at, double,
                                  double) const {
  return {at[1],
          held_mm_s2_ + o.cogging_mm_s2 * std::sin(kTwoPi * at[0] / o.tooth_period_mm)};
}

LoopAxis::State LoopAxis::Slope(const State& at, double c, double c_s) const {
  return std::visit([&](const auto& o) { return SlopeOf(o, at, c, c_s); }, options_);
}

// The poles (s^2 + 2 d w s + w^2)(s + r) give the continuous gains; an increment a
// period.
void LoopAxis::Sample(const PlanarOptions& o, double commanded) {
  const double w = kTwoPi * o.natural_frequency_hz, r = o.integral_rate_per_s;
  const double proportional = w * w + 2 * o.damping_ratio * w * r;
  const double integral = w * w * r * o.period_s;
  const double derivative = (2 * o.damping_ratio * w + r) / o.period_s;
  const double wrong_mm =
      o.sensor_error_mm * std::sin(2 * kTwoPi * state_[0] / o.tooth_period_mm);
  const double division_mm = o.tooth_period_mm / kDivision;
  const double measured = division_mm * std::round((state_[0] + wrong_mm) / division_mm);
  const double error = commanded - measured;
  held_mm_s2_ += integral * error + proportional * (error - last_error_) +
                 derivative * (error - 2 * last_error_ + error_before_);
  error_before_ = last_error_;
  last_error_ = error;
}

void LoopAxis::Step(const AxisCommand& command, double from_s, double step_s) {
  const auto* servo = std::get_if<ServoOptions>(&options_);
  const bool rubs = servo != nullptr && servo->friction_mm_s2 > 0;
  if (rubs) {
    const double pull =
        MotorAcceleration(*servo, state_, command.At(from_s), command.SpeedAt(from_s)) -
        servo->load_mm_s2;
    if (state_[1] == 0 && std::abs(pull) <= servo->friction_mm_s2) return;
    friction_sign_ = std::copysign(1.0, state_[1] != 0 ? state_[1] : pull);
  }
  const auto slope = [&](const State& at, double s) {
    return Slope(at, command.At(s), command.SpeedAt(s));
  };
  const auto along = [&](const State& by, double h) {
    State next = state_;
    for (std::size_t i = 0; i < next.size(); ++i) next[i] += h * by[i];
    return next;
  };
  const double half_s = step_s / 2;
  const State k1 = slope(state_, from_s);
  const State k2 = slope(along(k1, half_s), from_s + half_s);
  const State k3 = slope(along(k2, half_s), from_s + half_s);
  const State k4 = slope(along(k3, step_s), from_s + step_s);
  for (std::size_t i = 0; i < state_.size(); ++i)
    state_[i] += step_s / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  // Friction stops it, it does not send it back.
  if (rubs && state_[1] * friction_sign_ < 0) state_[1] = 0;
}

bool LoopAxis::Rests(const AxisCommand& command) const {
  if (command.v != 0 || command.c2 != 0 || command.c3 != 0) return false;
  // The motor of a cascade has to be where it is commanded.
  if (std::holds_alternative<CascadeOptions>(options_) &&
      std::abs(command.p - state_[2]) > kRestMmS) {
    return false;
  }
  const State slope = Slope(state_, command.p, 0);
  return std::abs(slope[0]) < kRestMmS && std::abs(slope[2]) < kRestMmS &&
         std::abs(slope[1]) < kRestMmS2 && std::abs(slope[3]) < kRestMmS2;
}

void LoopAxis::Follow(const AxisCommand& command, double from_s, double to_s) {
  const auto* planar = std::get_if<PlanarOptions>(&options_);
  if (planar == nullptr && Rests(command)) return;
  for (double at_s = from_s; at_s < to_s;) {
    if (planar != nullptr && to_sample_s_ <= 0) {
      Sample(*planar, command.At(at_s));
      to_sample_s_ += planar->period_s;
    }
    double until_s = to_s;
    if (planar != nullptr) until_s = std::min(to_s, at_s + to_sample_s_);
    const double way_s = until_s - at_s;
    const int steps = std::max(1, static_cast<int>(std::ceil(way_s / longest_step_s_)));
    for (int i = 0; i < steps; ++i)
      Step(command, at_s + i * way_s / steps, way_s / steps);
    if (planar != nullptr) to_sample_s_ = until_s < to_s ? 0 : to_sample_s_ - way_s;
    at_s = until_s;
  }
}

}  // namespace intaglio::virtual_engraver
