#pragma once

// What becomes of the light on its way through a block: R + A + T = 1 (Trochimczuk 2008
// ch. 5.3, eq. 2-6; technical glass, eq. 7: R 8-9 %, A 2.5-7 %, T 84-90 %).

#include <optional>
#include <span>

namespace intaglio::optics {

/// The internal transmittance of a catalog: what a way inside the glass leaves of the
/// light, without the reflections at its faces.
struct Transmittance {
  double wavelength_um = 0;  ///< > 0
  double ratio = 0;          ///< 0..1
  double thickness_mm = 0;   ///< > 0

  bool operator==(const Transmittance&) const = default;
};

/// The absorption coefficient a of exp(-a z), 1/mm: -ln(ratio) / thickness, linear
/// between the wavelengths of the table, which ascend. Unknown outside the table and
/// where the neighbouring entry lets nothing through (ratio 0).
std::optional<double> AbsorptionPerMm(std::span<const Transmittance> table,
                                      double wavelength_nm);

/// Shares of the light that arrives at the block, each 0..1; together 1.
struct LightShares {
  double reflected = 0;    ///< R, of both faces and all their echoes
  double absorbed = 0;     ///< A
  double transmitted = 0;  ///< T, what leaves through the bottom
};

/// Of a block with parallel faces in air, at normal incidence. reflectance: of one face,
/// 0..1 (fresnel.h); thickness_mm >= 0. With t = exp(-a d):
///   T = (1-r)^2 t / (1 - r^2 t^2),  R = r + r t T,  A = 1 - R - T.
LightShares SharesOfLight(double reflectance, double absorption_per_mm,
                          double thickness_mm);

/// The share of the light that reaches a depth below the top face, (1 - r) exp(-a z).
/// Without the echo of the bottom, which has no focus there.
double LightAtDepth(double reflectance, double absorption_per_mm, double depth_mm);

}  // namespace intaglio::optics
