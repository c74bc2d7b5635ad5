#pragma once

// The magnetic circuit of an electromagnetic module of the planar motor, with the teeth
// of its two poles half a period apart: Trochimczuk 2008, ch. 7.7, (116)-(128). Angles
// x0 = 2 pi x / tooth period; permeances in H, reluctances in 1/H, magnetomotive forces
// in A, fluxes in Wb. Corrected: (121) has the permeances of the two poles of a module,
// printed 1A and 1B; (122) has cos^2 x, printed cos 2x; the constant of (126) has the
// fourth power, which the second and fourth harmonics have; (127) has x0 in its first
// harmonic, printed 2 x0; (128) changes the sign of the odd harmonics alone.

#include <array>

namespace intaglio::drive {

/// A constant and the amplitudes of the harmonics 1 to 4 of x0.
using Harmonics = std::array<double, 5>;

/// (117), (123), (127): the first pole. The constant is > 0, the others are so small that
/// the value is.
double AtPole1(const Harmonics& harmonics, double x0_rad);
/// The second pole, half a period on: the odd harmonics have the other sign.
double AtPole2(const Harmonics& harmonics, double x0_rad);

/// (118), (126): the reluctance of a pole whose permeance has a constant and the first
/// harmonic alone, as a series in their ratio (below 1), to its fourth power. As in
/// (128) the amplitude of the first and of the third harmonic is negative.
Harmonics ReluctanceOf(double constant_h, double first_h);

/// (119), (120): the flux of a coil of this force through both poles in series, twice.
double CoilFlux(const Harmonics& permeance, double coil_a, double x0_rad);
/// (121), (122): the flux of a magnet of this force and reluctance through the two poles
/// beside each other, of either side.
double MagnetFlux(const Harmonics& permeance, double magnet_a, double magnet_per_h,
                  double x0_rad);

}  // namespace intaglio::drive
