#pragma once

// A servo axis as its controller drives it: the position is read and the voltage set once
// a period and held in between. The axis is stepped exactly from sample to sample
// (zero-order hold). Positions in m, or any one unit of length for all.
//
//   tau x'' + x' = g U - tau (load + friction),   g = K1 Kg, m/s per V
//   U = volt_per_m e + volt_s_per_m (e - e before) / period
//       + phi (r - r before) / (g period),        e = r - x as it is read

#include <optional>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drive/motor.h"

namespace intaglio::drive {

struct SampledAxis {
  double speed_per_volt = 0;   ///< g, m/s per V, > 0
  double velocity_time_s = 0;  ///< tau, > 0
  PositionLoop loop;
  double period_s = 0;  ///< of the controller, > 0
  // Without a value: ideal.
  std::optional<double> volt_per_step;  ///< of the converter, > 0
  std::optional<double> max_volt;       ///< > 0
  std::optional<double> counts_per_m;   ///< of the encoder, > 0
  double load_m_s2 = 0;                 ///< of a constant force towards -
  double friction_m_s2 = 0;             ///< Coulomb's, >= 0
};

/// The controller's period from which on the loop is not stable, s; between 0.1 us and
/// 10 s, 0 where it is not stable with the shortest. Without quantization and limits.
double LargestStablePeriod(const SampledAxis& axis);

struct AxisSample {
  double position_m = 0, speed_m_s = 0;
  double acceleration_m_s2 = 0;  ///< just behind the sample
  double volt = 0;               ///< from the sample on
  double following_error_m = 0;  ///< commanded minus actual
};

/// `setpoints_m`: commanded at each sample, from rest at the first. kInvalidValue for an
/// axis that is not stable, with the largest stable period. Throws PreconditionError
/// when a value is outside the ranges above.
Result<std::vector<AxisSample>> Simulate(const SampledAxis& axis,
                                         std::span<const double> setpoints_m);

}  // namespace intaglio::drive
