#pragma once

// The drives of controlled and of stepped axes, as transfer functions (transfer.h). All
// are stable over the whole of their parameters but a planar drive whose period is too
// long, and so are their inverses.

#include "engrave/drive/transfer.h"

namespace intaglio::drive {

/// A position loop around a closed velocity loop (Tirnovean 2016, (3.10)-(3.23), in SI
/// units): tau x'' + x' = K (c - x) + D (c' - x') + F c'.
struct ServoLoop {
  double position_gain_per_s = 0;  ///< K, > 0
  double velocity_time_s = 0;      ///< tau, > 0
  double derivative_ratio = 0;     ///< D, >= 0
  double feed_forward_ratio = 0;   ///< F, >= 0; at 1 there is no lag at constant speed
};
Transfer TransferOf(const ServoLoop& servo);

/// Position, velocity and current loop with gains as 1 : 3 : 12 and mechanics on a spring
/// behind them (Zarudnev 2007): 1 / (1 + s/w + s^2/(3 w^2) + s^3/(36 w^3)) times
/// 1 / (1 + 2 d s/m + s^2/m^2), m = 2 pi natural_frequency_hz.
struct CascadeLoop {
  double position_gain_per_s = 0;   ///< w, > 0
  double natural_frequency_hz = 0;  ///< > 0
  double damping_ratio = 0;         ///< d, > 0
};
Transfer TransferOf(const CascadeLoop& cascade);

/// A stepper without feedback and a screw, of Trochimczuk 2008, (109)-(115) with the
/// current given: the rotor u is held by its field at c, the carried mass x by the screw
/// at u. With p and q the circular frequencies and m the ratio of the inertias
///   u'' = p^2 (c - u) - 2 d1 p u' - m f,  x'' = f,  f = q^2 (u - x) + 2 d2 q (u' - x').
struct StepperScrewLoop {
  double rotor_frequency_hz = 0;      ///< > 0
  double rotor_damping_ratio = 0;     ///< d1, > 0
  double carriage_frequency_hz = 0;   ///< > 0
  double carriage_damping_ratio = 0;  ///< d2, > 0
  double inertia_ratio = 0;           ///< m, >= 0
};
Transfer TransferOf(const StepperScrewLoop& stepper);

/// A mass without a transmission under PID, Trochimczuk 2008, (105)-(106) corrected, by
/// the poles of the loop: x''' = kd (c'' - x'') + kp (c' - x') + ki (c - x) has the
/// denominator (s^2 + 2 d w s + w^2)(s + r). A controller of period T holds what it
/// computes, and takes differences of what it samples: each is T / 2 late.
struct PlanarLoop {
  double natural_frequency_hz = 0;  ///< > 0
  double damping_ratio = 0;         ///< d, > 0
  double integral_rate_per_s = 0;   ///< r, > 0
  double period_s = 0;              ///< T, >= 0; 0: continuous
};
struct PidGains {
  double proportional_per_s2 = 0, integral_per_s3 = 0, derivative_per_s = 0;
};
PidGains GainsOf(const PlanarLoop& planar);
/// Stable only up to LongestPeriodS.
Transfer TransferOf(const PlanarLoop& planar);
/// The period of the controller at which the loop begins to swing, s, > 0; the loop's own
/// period is not read.
double LongestPeriodS(const PlanarLoop& planar);

}  // namespace intaglio::drive
