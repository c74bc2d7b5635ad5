#include "engrave/optics/crack_model.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

constexpr double kMjPerJ = 1000;
constexpr double kMm3PerM3 = 1e9;
constexpr double kMm2PerM2 = 1e6;

void CheckCrack(const CrackSize& crack) {
  Require(crack.diameter_mm > 0 && crack.length_mm > 0,
          "a crack of {} x {} mm has no size", crack.diameter_mm, crack.length_mm);
}

/// pi/6 d^2 l
double VolumeMm3(const CrackSize& crack) {
  return std::numbers::pi / 6 * crack.diameter_mm * crack.diameter_mm * crack.length_mm;
}

}  // namespace

double MeltingEnergyMjMm3(const MeltingProperties& glass) {
  Require(glass.density_kg_m3 > 0 && glass.specific_heat_j_kg_k > 0 &&
              glass.melting_point_c > kRoomTemperatureC,
          "density {} kg/m3 and specific heat {} J/(kg K) must be positive, the melting "
          "point {} C above {} C",
          glass.density_kg_m3, glass.specific_heat_j_kg_k, glass.melting_point_c,
          kRoomTemperatureC);
  return glass.density_kg_m3 * glass.specific_heat_j_kg_k *
         (glass.melting_point_c - kRoomTemperatureC) * kMjPerJ / kMm3PerM3;
}

CrackSize MeltingBound(const MeltingProperties& glass, double energy_mj,
                       double length_ratio) {
  Require(energy_mj > 0 && length_ratio > 0,
          "energy {} mJ and length by diameter {} must be positive", energy_mj,
          length_ratio);
  const double volume_mm3 = energy_mj / MeltingEnergyMjMm3(glass);
  const double diameter_mm =
      std::cbrt(6 * volume_mm3 / (std::numbers::pi * length_ratio));
  return {diameter_mm, length_ratio * diameter_mm};
}

double SurfaceEnergyMj(const CrackSize& crack, double surface_energy_j_m2) {
  CheckCrack(crack);
  Require(surface_energy_j_m2 > 0, "surface_energy_j_m2 must be positive, is {}",
          surface_energy_j_m2);
  const double area_m2 =
      std::numbers::pi / 4 * crack.diameter_mm * crack.length_mm / kMm2PerM2;
  return 2 * surface_energy_j_m2 * area_m2 * kMjPerJ;
}

double HeatedShare(const MeltingProperties& glass, const CrackSize& measured,
                   double energy_mj) {
  CheckCrack(measured);
  Require(energy_mj > 0, "energy_mj must be positive, is {}", energy_mj);
  return VolumeMm3(measured) * MeltingEnergyMjMm3(glass) / energy_mj;
}

CrackSize CrackOfEnergy(const CrackSize& measured, double measured_energy_mj,
                        double energy_mj) {
  const double surface_mj = SurfaceEnergyMj(measured);
  Require(measured_energy_mj > surface_mj,
          "a crack of {} x {} mm takes more than {} mJ, it was measured at {} mJ",
          measured.diameter_mm, measured.length_mm, surface_mj, measured_energy_mj);
  Require(energy_mj >= 0, "energy_mj must not be negative, is {}", energy_mj);
  if (energy_mj <= surface_mj) return {};
  const double scale =
      std::cbrt((energy_mj - surface_mj) / (measured_energy_mj - surface_mj));
  return {scale * measured.diameter_mm, scale * measured.length_mm};
}

}  // namespace intaglio::optics
