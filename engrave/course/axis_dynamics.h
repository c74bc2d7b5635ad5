#pragma once

// How a feed axis follows its command: a position loop whose motor drives the load
// through elastic mechanics, all linear,
//   motor  = command / L(s),   load = motor / M(s),   L(0) = M(0) = 1.
// The load is where the beam is. Times in s, frequencies in rad/s, s in 1/s.
//
// Source: Zarudnev 2007, (5): L = T s + 1 with T = 1 / w_c and M = tau^2 s^2 + 2 xi tau s
// + 1 with tau = 1 / w. A cascade of current, velocity and position loops whose
// bandwidths are as 12 : 3 : 1 closes to L = 1 + s / w_c + s^2 / (3 w_c^2) + s^3 / (36
// w_c^3), not to the first order that (5) assumes.

#include <array>
#include <complex>
#include <span>
#include <vector>

namespace intaglio::course {

enum class LoopKind {
  kFirstOrder,  ///< (5) of the source
  kCascade,     ///< 1 : 3 : 12
};

struct AxisParameters {
  LoopKind loop = LoopKind::kFirstOrder;
  /// w_c, 0.1..1e6; infinite: the motor is where it is commanded.
  double bandwidth_rad_s = 0;
  /// w, 0.1..1e6; infinite: the mechanics are rigid.
  double natural_rad_s = 0;
  double damping_ratio = 0;  ///< xi, 0.01..5; not read of rigid mechanics
};

class AxisDynamics {
 public:
  /// Throws PreconditionError when a parameter is outside its range.
  explicit AxisDynamics(const AxisParameters& parameters);

  const AxisParameters& parameters() const { return parameters_; }
  /// Polynomials in s by ascending power, the first is 1; command = L M load.
  const std::vector<double>& loop() const { return loop_; }
  const std::vector<double>& mechanics() const { return mechanics_; }
  const std::vector<double>& product() const { return product_; }
  /// Behind a ramp of the command, in time: L'(0) + M'(0).
  double lag_s() const { return product_.size() > 1 ? product_[1] : 0; }
  /// The roots of the product, each with a negative real part. Equal roots are moved
  /// apart by 1e-6 of their size.
  const std::vector<std::complex<double>>& poles() const { return poles_; }

  /// The same axis with other mechanics: factors on natural frequency and damping.
  AxisDynamics WithMechanics(double frequency_ratio, double damping_ratio) const;

 private:
  AxisParameters parameters_;
  std::vector<double> loop_, mechanics_, product_;
  std::vector<std::complex<double>> poles_;
};

using AxisPair = std::array<AxisDynamics, 2>;

/// (4): w_c = w1 w2 / sqrt(w1^2 + w2^2), the bandwidth of both axes. With the first order
/// and xi = 0 the mean radius of a circle is kept to second order.
double CommonBandwidth(double natural_1_rad_s, double natural_2_rad_s);

/// Two axes with this bandwidth.
AxisPair TunedAxes(double natural_1_rad_s, double natural_2_rad_s, double damping_1_ratio,
                   double damping_2_ratio, LoopKind loop = LoopKind::kFirstOrder);

}  // namespace intaglio::course
