#pragma once

// An axis as a mass on a spring with a damper. A position loop around a drive with closed
// velocity loop has the same equation:
//   x'' + 2 d w x' + w^2 x = w^2 c,   w = 2 pi natural_frequency_hz, d the damping ratio.
// It passes a point at speed v a distance 2 d v / w late: 0.15 mm at 80 mm/s, 120 Hz and
// d = 0.7. With the command c = p + 2 d p' / w + p'' / w^2 it follows the course p.

#include "engrave/drive/drive.h"

namespace intaglio::drive {

/// Below 1 Hz a stage does not pass ten points a second; above 10 kHz its lag is less
/// than the rounding of commands to nm.
inline constexpr double kMinNaturalFrequencyHz = 1;
inline constexpr double kMaxNaturalFrequencyHz = 10000;
/// Below this it rings for more than ten periods, which is unusable for engraving.
inline constexpr double kMinDampingRatio = 0.05;
inline constexpr double kMaxDampingRatio = 5;

class SecondOrder final : public Drive {
 public:
  /// Within the ranges above. Throws PreconditionError.
  SecondOrder(double natural_frequency_hz, double damping_ratio);

  std::string_view name() const override { return "second_order"; }
  AxisState Follow(const AxisState& state, const Cubic& command,
                   double duration_s) const override;
  Cubic Settled(const Cubic& command) const override;
  AxisState SettledState(const Cubic& command) const override;
  Transfer transfer() const override {
    return {{1}, {1, velocity_lag_s_, acceleration_lag_s2_}};
  }
  Cubic CommandFor(const Cubic& course) const override;
  double lead_s2() const override;

 private:
  double natural_rad_s_;
  double damping_ratio_;
  double velocity_lag_s_;       // 2 d / w
  double acceleration_lag_s2_;  // 1 / w^2
};

}  // namespace intaglio::drive
