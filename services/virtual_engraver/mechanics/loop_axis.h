#pragma once

// One axis under a control loop or a stepper: the differential equation of the whole
// drive, integrated in short steps (Runge-Kutta, fourth order), so that what is not
// linear is as it is: friction, a motor at its limit, lost steps, a sampled controller, a
// sensor that is wrong. Written for itself: it shares nothing with engrave/drive.
// Position x and command c in mm, or rad of an axis that turns.

#include <array>
#include <cstdint>
#include <variant>

namespace intaglio::virtual_engraver {

/// A position loop around a velocity loop:
/// x'' = limited((K (c - x) + D (c' - x') + F c' - x') / tau) - load - friction.
struct ServoOptions {
  double position_gain_per_s = 100;     ///< K, > 0
  double velocity_time_s = 0.003;       ///< tau, > 0
  double derivative_ratio = 0;          ///< D, >= 0
  double feed_forward_ratio = 0;        ///< F, >= 0
  double load_mm_s2 = 0;                ///< towards - where it is positive
  double friction_mm_s2 = 0;            ///< >= 0, Coulomb's
  double max_acceleration_mm_s2 = 1e6;  ///< > 0, of the motor
};

/// Current, velocity and position loops of 12, 3 and 1 times the gain; a mass on a spring
/// follows the motor.
struct CascadeOptions {
  double position_gain_per_s = 100;   ///< > 0
  double natural_frequency_hz = 100;  ///< > 0
  double damping_ratio = 0.7;         ///< > 0
};

/// A rotor in a field that repeats every four full steps, and a mass that a screw takes
/// along. Frequencies and ratios: each part by itself, as in the truth file.
struct StepperOptions {
  double rotor_frequency_hz = 100;      ///< > 0
  double rotor_damping_ratio = 0.5;     ///< > 0
  double carriage_frequency_hz = 200;   ///< > 0
  double carriage_damping_ratio = 0.1;  ///< > 0
  double inertia_ratio = 0.5;           ///< >= 0
  double full_step_mm = 0.025;          ///< > 0
};

/// A linear motor under an incremental PID controller that samples its sensor.
struct PlanarOptions {
  double natural_frequency_hz = 50;  ///< > 0
  double damping_ratio = 0.7;        ///< > 0
  double integral_rate_per_s = 10;   ///< > 0
  double period_s = 0.0002;          ///< > 0
  double tooth_period_mm = 0.64;     ///< > 0
  double cogging_mm_s2 = 0;          ///< >= 0
  double sensor_error_mm = 0;        ///< >= 0
};

using LoopOptions =
    std::variant<ServoOptions, CascadeOptions, StepperOptions, PlanarOptions>;

/// The same axis without what disturbs it: load, friction, limits, lost steps, cogging
/// and errors of the sensor.
LoopOptions Undisturbed(LoopOptions options);

/// p + v s + c2 s^2 + c3 s^3, s in seconds.
struct AxisCommand {
  double p = 0, v = 0, c2 = 0, c3 = 0;

  double At(double s) const { return p + s * (v + s * (c2 + s * c3)); }
  double SpeedAt(double s) const { return v + s * (2 * c2 + 3 * s * c3); }
};

class LoopAxis {
 public:
  /// At rest at `at`.
  LoopAxis(const LoopOptions& options, double at);

  /// From `from_s` to `to_s` >= from_s of the command.
  void Follow(const AxisCommand& command, double from_s, double to_s);
  double actual() const { return state_[0]; }
  /// At rest where it is, as after a hand that held it.
  void Rest();
  /// How much later than its command it is at constant speed, without load, s.
  double velocity_lag_s() const;

 private:
  // x, x', then: rotor and its speed, or motor, its speed and its acceleration.
  using State = std::array<double, 5>;
  State Slope(const State& at, double c, double c_s) const;
  State SlopeOf(const ServoOptions& o, const State& at, double c, double c_s) const;
  State SlopeOf(const CascadeOptions& o, const State& at, double c, double c_s) const;
  State SlopeOf(const StepperOptions& o, const State& at, double c, double c_s) const;
  State SlopeOf(const PlanarOptions& o, const State& at, double c, double c_s) const;
  /// It stays where it is, whatever comes.
  bool Rests(const AxisCommand& command) const;
  void Step(const AxisCommand& command, double from_s, double step_s);
  double MotorAcceleration(const ServoOptions& o, const State& at, double c,
                           double c_s) const;
  void Sample(const PlanarOptions& o, double commanded);

  LoopOptions options_;
  State state_ = {};
  double longest_step_s_;
  double friction_sign_ = 0;  // of a servo, during a step; 0 and resting: it is held
  // The time to the next sample, for a controller that samples.
  double to_sample_s_ = 0;
  double held_mm_s2_ = 0, last_error_ = 0, error_before_ = 0;
};

}  // namespace intaglio::virtual_engraver
