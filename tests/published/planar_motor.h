#pragma once

// A planar (linear stepping) motor and its sensor (Trochimczuk 2008, ch. 6.6 and 8.3):
// phase currents, the incremental controller and the sine/cosine sensor.

#include <cstdint>

namespace intaglio::drive {

struct PhaseCurrents {
  double first_a = 0, second_a = 0;
};

/// Open loop, (103): I (sin p - K3 sin 3p) / (1 + K3) and I (cos p + K3 cos 3p) / (1 +
/// K3), p = 2 pi x / tooth period. `third_harmonic_ratio` K3, 0..0.3. Throws
/// PreconditionError for a period that is not positive or a K3 outside.
PhaseCurrents OpenLoopCurrents(double amplitude_a, double x_mm, double tooth_period_mm,
                               double third_harmonic_ratio);

/// Closed loop, (107), at the measured place with the lead F(V), rad, 0..pi/2; the third
/// harmonic has the other sign and the currents are normalized by 1 - K3.
PhaseCurrents ClosedLoopCurrents(double current_a, double x_mm, double tooth_period_mm,
                                 double third_harmonic_ratio, double lead_rad);

/// I(n) = I(n-1) + Ki e(n) + Kp (e(n) - e(n-1)) + Kd (e(n) - 2 e(n-1) + e(n-2)); (105),
/// (106), both corrected.
class IncrementalPid {
 public:
  IncrementalPid(double proportional, double integral, double derivative)
      : proportional_(proportional), integral_(integral), derivative_(derivative) {}

  double Next(double error);

 private:
  double proportional_, integral_, derivative_;
  double output_ = 0, last_ = 0, before_ = 0;
};

/// A sensor that divides the period of two signals, one a quarter of a period behind the
/// other. What is wrong with the signals moves what it reads within every period.
struct SineCosineSensor {
  double period_mm = 0.64;                                ///< > 0; 0.64 to 0.65
  std::uint32_t division = 4096;                          ///< > 0
  double sine_offset_ratio = 0, cosine_offset_ratio = 0;  ///< of the amplitude
  double gain_ratio = 1;       ///< amplitude of the cosine over that of the sine, > 0
  double phase_error_rad = 0;  ///< of the cosine

  double resolution_mm() const { return period_mm / division; }
};
/// What it reads at x. Throws PreconditionError.
double Read(const SineCosineSensor& sensor, double x_mm);
/// A bound of the interpolation error without the division, mm: period / (2 pi) times
/// (the length of the offsets + |gain - 1| / 2 + |phase| / 2), in the first order.
double InterpolationError(const SineCosineSensor& sensor);

}  // namespace intaglio::drive
