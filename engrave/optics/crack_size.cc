#include "engrave/optics/crack_size.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

using std::numbers::pi;

constexpr double kMm3PerM3 = 1e9;
constexpr double kJPerMj = 1e-3;

void RequireSize(const CrackSize& crack) {
  Require(crack.diameter_mm > 0 && crack.length_mm > 0, "a crack of {} x {} mm",
          crack.diameter_mm, crack.length_mm);
}

}  // namespace

CrackSize CrackSizeAt(const CrackSize& measured, double measured_mj, double energy_mj) {
  RequireSize(measured);
  Require(measured_mj > 0 && energy_mj > 0, "pulses of {} and {} mJ", measured_mj,
          energy_mj);
  const double ratio = std::cbrt(energy_mj / measured_mj);
  return {measured.diameter_mm * ratio, measured.length_mm * ratio};
}

double CrackVolume_mm3(const CrackSize& crack) {
  RequireSize(crack);
  return pi / 6 * crack.diameter_mm * crack.diameter_mm * crack.length_mm;
}

// With the half axes a across and c along the beam: 2 pi a^2 (1 + c/a x), where x is
// asin(e)/e of a long spheroid and atanh(e)/e (1 - e^2) a/c of a flat one.
double CrackSurface_mm2(const CrackSize& crack) {
  RequireSize(crack);
  const double a = crack.diameter_mm / 2, c = crack.length_mm / 2;
  if (std::abs(c - a) < 1e-9 * a) return 4 * pi * a * a;
  if (c > a) {
    const double e = std::sqrt(1 - a * a / (c * c));
    return 2 * pi * a * a * (1 + c / (a * e) * std::asin(e));
  }
  const double e = std::sqrt(1 - c * c / (a * a));
  return 2 * pi * a * a * (1 + (1 - e * e) / e * std::atanh(e));
}

double MeltingBound_mm3(const HeatedGlass& glass, double energy_mj) {
  Require(glass.density_kg_m3 > 0 && glass.specific_heat_j_kg_k > 0 &&
              glass.start_k > 0 && glass.melting_point_k > glass.start_k,
          "a glass of {} kg/m^3, {} J/(kg K), {} K, melting at {} K", glass.density_kg_m3,
          glass.specific_heat_j_kg_k, glass.start_k, glass.melting_point_k);
  Require(energy_mj > 0, "a pulse of {} mJ", energy_mj);
  const double heat_j_m3 = glass.density_kg_m3 * glass.specific_heat_j_kg_k *
                           (glass.melting_point_k - glass.start_k);
  return kMm3PerM3 * kJPerMj * energy_mj / heat_j_m3;
}

}  // namespace intaglio::optics
