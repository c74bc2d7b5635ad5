#include "services/job/quality/pulse_focus.h"

#include "engrave/optics/crack_model.h"
#include "engrave/optics/focus_heat.h"
#include "engrave/optics/pulse_focus.h"
#include "services/job/job_defaults.h"

namespace intaglio {
namespace {

constexpr double kUmPerMm = 1000;
constexpr double kWPerMw = 1e6, kWPerGw = 1e9;

void AddSpot(const LaserHead& laser, const MachineLens& lens, PulseFocusRecord& focus) {
  if (laser.divergence_mrad() > 0) {
    focus.set_spot_diameter_um(
        kUmPerMm *
        optics::SpotDiameterMm(lens.focal_length_mm(), laser.divergence_mrad()));
  }
  if (laser.pulse_duration_ns() <= 0) return;
  const double power_w =
      optics::PeakPowerW(focus.pulse_energy_mj(), laser.pulse_duration_ns());
  focus.set_peak_power_mw(power_w / kWPerMw);
  if (!focus.has_spot_diameter_um()) return;
  focus.set_peak_irradiance_gw_cm2(
      optics::IrradianceWCm2(power_w, focus.spot_diameter_um() / kUmPerMm) / kWPerGw);
}

/// The heat is that which melts the volume of the measured crack.
void AddHeat(const MaterialRecord& glass, const OpticalValuesRecord& values,
             const MachineLens& lens, PulseFocusRecord& focus) {
  const optics::MeltingProperties melting{
      glass.density_kg_m3(), glass.specific_heat_j_kg_k(), glass.melting_point_c()};
  const optics::ConductingProperties conducting{
      glass.density_kg_m3(), glass.specific_heat_j_kg_k(), glass.conductivity_w_m_k()};
  const optics::CrackSize crack{lens.crack_diameter_mm(), lens.crack_length_mm()};
  const double energy_mj = focus.pulse_energy_mj();
  focus.set_heated_ratio(optics::HeatedShare(melting, crack, energy_mj));
  const double heat_mj = focus.heated_ratio() * energy_mj;
  const auto diameter_um = [&](double rise_k) {
    return 2 * kUmPerMm * optics::HeatedRadiusMm(conducting, heat_mj, rise_k);
  };
  focus.set_melted_diameter_um(
      diameter_um(glass.melting_point_c() - optics::kRoomTemperatureC));
  if (values.has_local_thermal_strength_k() && values.local_thermal_strength_k() > 0)
    focus.set_strained_diameter_um(diameter_um(values.local_thermal_strength_k()));
  focus.set_cooling_s(optics::CoolingSeconds(conducting, crack.diameter_mm / 2));
  focus.set_next_point_rise_k(optics::TemperatureRiseK(
      conducting, heat_mj, crack.diameter_mm, 1 / focus.rate_hz()));
}

}  // namespace

PulseFocusRecord PulseFocusOf(const MaterialRecord& glass,
                              const OpticalValuesRecord& values, const LaserHead& laser,
                              const MachineLens& lens) {
  PulseFocusRecord focus;
  focus.set_lens(lens.name());
  const double split = laser.has_split_ratio() ? laser.split_ratio() : 1;
  focus.set_pulse_energy_mj(split * laser.pulse_energy_mj());
  focus.set_rate_hz(DefaultRateHz(laser));
  AddSpot(laser, lens, focus);
  const bool crack = lens.crack_diameter_mm() > 0 && lens.crack_length_mm() > 0;
  const bool heat = glass.density_kg_m3() > 0 && glass.specific_heat_j_kg_k() > 0 &&
                    glass.conductivity_w_m_k() > 0 &&
                    glass.melting_point_c() > optics::kRoomTemperatureC;
  if (crack && heat && focus.rate_hz() > 0) AddHeat(glass, values, lens, focus);
  if (crack && glass.youngs_modulus_gpa() > 0 && glass.has_poisson_ratio() &&
      glass.density_kg_m3() > 0) {
    const double waves_m_s = optics::TransverseWaveSpeedMS(
        glass.youngs_modulus_gpa(), glass.poisson_ratio(), glass.density_kg_m3());
    focus.set_crack_growth_s(
        optics::CrackGrowthSeconds(lens.crack_length_mm(), waves_m_s));
  }
  return focus;
}

}  // namespace intaglio
