#include "engrave/optics/pulse_focus.h"

#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {

double ApertureOfBeam(double beam_diameter_mm, double focal_length_mm) {
  Require(beam_diameter_mm > 0 && focal_length_mm > 0,
          "beam {} mm and focal length {} mm must be positive", beam_diameter_mm,
          focal_length_mm);
  return beam_diameter_mm / (2 * focal_length_mm);
}

double SpotDiameterMm(double focal_length_mm, double divergence_mrad) {
  Require(focal_length_mm > 0 && divergence_mrad > 0,
          "focal length {} mm and divergence {} mrad must be positive", focal_length_mm,
          divergence_mrad);
  return focal_length_mm * divergence_mrad / 1000;
}

double PeakPowerW(double energy_mj, double duration_ns) {
  Require(energy_mj >= 0 && duration_ns > 0,
          "energy {} mJ must not be negative, duration {} ns positive", energy_mj,
          duration_ns);
  return energy_mj / duration_ns * 1e6;
}

double IrradianceWCm2(double power_w, double spot_diameter_mm) {
  Require(spot_diameter_mm > 0, "spot_diameter_mm must be positive, is {}",
          spot_diameter_mm);
  const double area_cm2 =
      std::numbers::pi / 4 * spot_diameter_mm * spot_diameter_mm / 100;
  return power_w / area_cm2;
}

}  // namespace intaglio::optics
