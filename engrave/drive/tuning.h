#pragma once

// Gains of servo axes that move together, each with its reason and what limits it.

#include <span>
#include <string>
#include <vector>

#include "engrave/drive/motor.h"

namespace intaglio::drive {

/// What the axes do most.
enum class Regime {
  kRapid,   ///< from place to place, one axis or all, with a stop at the end
  kCircle,  ///< curves at constant speed, both axes together
  kCorner,  ///< lines that meet, one axis after the other
};

struct TunedAxis {
  std::string name;
  VelocityLoop velocity;
  double lead_m = 0;  ///< > 0
  /// Current per volt of the amplifier's output into the resting motor: Ka / R.
  double amplifier_a_per_v = 0;       ///< > 0
  double peak_current_a = 0;          ///< > 0
  double moving_current_a = 0;        ///< of acceleration and load, < peak_current_a
  double load_acceleration_m_s2 = 0;  ///< of a constant load; for the static error
};

struct TuningDemand {
  Regime regime = Regime::kRapid;
  double speed_m_s = 0;             ///< > 0, the largest
  double period_s = 0;              ///< > 0, of the controller
  bool references_are_held = true;  ///< setpoints jump once a period
  double damping_ratio = 0.7;       ///< of the loop, > 0
};

struct Advice {
  std::string gain;  ///< e.g. "position gain, 1/s"
  double value = 0;
  double limit = 0;    ///< not above it
  std::string reason;  ///< a sentence
};

struct Tuning {
  std::string axis;
  PositionLoop loop;
  ServoLoop servo;
  double following_lag_s = 0;
  double static_error_m = 0;
  double largest_stable_period_s = 0;
  std::vector<Advice> advice;
};

/// K is that of the slowest axis, min 1 / (4 zeta^2 tau), on all of them: unequal gains
/// make an ellipse of a circle, (K1 - K2) / (2 K1 K2) times the speed (rule (4) of
/// Zarudnev 2007). Where the period of the controller asks for less, K is halved until a
/// tenth of the largest stable period is left. `axes` not empty. Throws
/// PreconditionError when a value is outside the ranges above.
std::vector<Tuning> Tune(std::span<const TunedAxis> axes, const TuningDemand& demand);

}  // namespace intaglio::drive
