#pragma once

// The spot that a lens makes of a laser's beam, and the power of a pulse there
// (Trochimczuk 2008, annex C, table 8: divergence 1 mrad, diameter of the beam 5 mm,
// pulses of 12 ns).

namespace intaglio::optics {

/// Of a beam that is this wide at a lens, NA = D / (2 f). Both > 0.
double ApertureOfBeam(double beam_diameter_mm, double focal_length_mm);

/// Diameter of the spot, mm: the focal length times the full angle of the beam, as long
/// as that is far above the limit of diffraction (43 um at f = 43 mm and 1 mrad, where
/// diffraction makes 11 um). Both > 0.
double SpotDiameterMm(double focal_length_mm, double divergence_mrad);

/// Energy by duration, W. The peak of a pulse whose duration is at half of its height is
/// 0.94 of it when its course is a Gaussian. Duration > 0, energy >= 0.
double PeakPowerW(double energy_mj, double duration_ns);

/// Power over the area of a spot, W/cm^2. Diameter > 0.
double IrradianceWCm2(double power_w, double spot_diameter_mm);

}  // namespace intaglio::optics
