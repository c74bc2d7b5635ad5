#pragma once

// How much light the block's top face takes away, and what is left at depth. From air
// (index 1) into glass of index n >= 1; unpolarised light; ratios of power, 0..1.

namespace intaglio::optics {

/// ((n - 1) / (n + 1))^2.
double ReflectanceAtNormalIncidence(double refractive_index);

/// Fresnel's equations, the mean of both polarisations. incidence_rad: angle to the
/// face's normal in air, 0..pi/2.
double Reflectance(double refractive_index, double incidence_rad);

/// What passes the top face: 1 - Reflectance; a face absorbs nothing.
double TopFaceTransmittance(double refractive_index, double incidence_rad);

/// Where the light of a beam goes: R + A + T = 1 (Trochimczuk 2008 ch. 5, eq. 6).
/// Technical glass as a rule: R 8-9 % (both faces), A 2.5-7 %, T 84-90 %.
struct LightBalance {
  double reflected_ratio = 0;
  double absorbed_ratio = 0;
  double transmitted_ratio = 0;
};

/// At a path's end inside the glass: reflected at the top face, absorbed along the path
/// (Lambert's law, absorption_per_mm >= 0, path_mm >= 0), the rest transmitted.
LightBalance LightAtDepth(double refractive_index, double incidence_rad,
                          double absorption_per_mm, double path_mm);

}  // namespace intaglio::optics
