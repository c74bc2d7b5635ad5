#include "engrave/optics/absorption.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// The echoes are a geometric series: the light that has entered, 1 - r, arrives at the
// bottom as (1 - r) t, leaves there by the share 1 - r, and comes back to the bottom
// after two reflections as (r t)^2 of it: T = (1-r) t (1-r) / (1 - (r t)^2). What leaves
// through the top after its last reflection at the bottom is r t of what left through the
// bottom.

namespace intaglio::optics {
namespace {

constexpr double kNmPerUm = 1000;

std::optional<double> CoefficientOf(const Transmittance& entry) {
  if (!(entry.ratio > 0 && entry.thickness_mm > 0)) return std::nullopt;
  return -std::log(std::min(entry.ratio, 1.0)) / entry.thickness_mm;
}

void CheckLight(double reflectance, double absorption_per_mm, double way_mm) {
  Require(reflectance >= 0 && reflectance <= 1, "reflectance must be in 0..1, is {}",
          reflectance);
  Require(absorption_per_mm >= 0, "absorption_per_mm must not be negative, is {}",
          absorption_per_mm);
  Require(way_mm >= 0, "the way in the glass must not be negative, is {} mm", way_mm);
}

}  // namespace

std::optional<double> AbsorptionPerMm(std::span<const Transmittance> table,
                                      double wavelength_nm) {
  const double wavelength_um = wavelength_nm / kNmPerUm;
  const auto above =
      std::ranges::lower_bound(table, wavelength_um, {}, &Transmittance::wavelength_um);
  if (above == table.end()) return std::nullopt;
  if (above->wavelength_um == wavelength_um) return CoefficientOf(*above);
  if (above == table.begin()) return std::nullopt;
  const Transmittance& below = *std::prev(above);
  const auto low = CoefficientOf(below), high = CoefficientOf(*above);
  if (!low || !high) return std::nullopt;
  return std::lerp(*low, *high,
                   (wavelength_um - below.wavelength_um) /
                       (above->wavelength_um - below.wavelength_um));
}

LightShares SharesOfLight(double reflectance, double absorption_per_mm,
                          double thickness_mm) {
  CheckLight(reflectance, absorption_per_mm, thickness_mm);
  const double r = reflectance, t = std::exp(-absorption_per_mm * thickness_mm);
  if (r == 1) return {.reflected = 1};
  LightShares shares;
  shares.transmitted = (1 - r) * (1 - r) * t / (1 - r * r * t * t);
  shares.reflected = r + r * t * shares.transmitted;
  shares.absorbed = std::max(0.0, 1 - shares.reflected - shares.transmitted);
  return shares;
}

double LightAtDepth(double reflectance, double absorption_per_mm, double depth_mm) {
  CheckLight(reflectance, absorption_per_mm, depth_mm);
  return (1 - reflectance) * std::exp(-absorption_per_mm * depth_mm);
}

}  // namespace intaglio::optics
