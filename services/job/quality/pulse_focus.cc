#include "services/job/quality/pulse_focus.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engrave/optics/crack_model.h"
#include "engrave/optics/focus_heat.h"
#include "engrave/optics/pulse_focus.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/machine_defaults.h"
#include "services/job/machine/pulse_energies.h"

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

optics::CrackSize CrackOf(const MachineLens& lens) {
  return {lens.crack_diameter_mm(), lens.crack_length_mm()};
}

/// The heat is the share of the pulse that melts the volume of the measured crack, which
/// is one of a pulse of `full_mj`.
void AddHeat(const MaterialRecord& glass, const OpticalValuesRecord& values,
             const MachineLens& lens, double full_mj, PulseFocusRecord& focus) {
  const optics::MeltingProperties melting{
      glass.density_kg_m3(), glass.specific_heat_j_kg_k(), glass.melting_point_c()};
  const optics::ConductingProperties conducting{
      glass.density_kg_m3(), glass.specific_heat_j_kg_k(), glass.conductivity_w_m_k()};
  const optics::CrackSize crack = CrackOf(lens);
  focus.set_heated_ratio(optics::HeatedShare(melting, crack, full_mj));
  const double heat_mj = focus.heated_ratio() * focus.pulse_energy_mj();
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

/// What the condition needs and is not there, as people name it.
void AddUnknown(const MaterialRecord& glass, const MachineLens& lens,
                PulseFocusRecord& focus) {
  const auto need = [&](bool known, const char* name) {
    if (!known) focus.add_unknown(name);
  };
  need(glass.density_kg_m3() > 0, "density");
  need(glass.specific_heat_j_kg_k() > 0, "specific heat");
  need(glass.conductivity_w_m_k() > 0, "conductivity");
  need(glass.melting_point_c() > optics::kRoomTemperatureC, "melting point");
  need(glass.tensile_strength_mpa() > 0, "tensile strength");
  need(glass.has_poisson_ratio(), "Poisson's ratio");
  need(glass.expansion_per_k() > 0, "expansion");
  need(glass.youngs_modulus_gpa() > 0, "Young's modulus");
  need(lens.crack_diameter_mm() > 0 && lens.crack_length_mm() > 0, "crack of the lens");
  need(focus.rate_hz() > 0 && focus.pulse_energy_mj() > 0,
       "rate and energy of the laser");
}

/// `full_mj`: the energy of the measured crack.
const char* ConditionOf(const PulseFocusRecord& focus, const MachineLens& lens,
                        double full_mj) {
  const optics::CrackSize measured = CrackOf(lens);
  if (full_mj <= optics::SurfaceEnergyMj(measured)) return kPulseTooWeak;
  const optics::CrackSize crack =
      optics::CrackOfEnergy(measured, full_mj, focus.pulse_energy_mj());
  if (crack.diameter_mm <= 0) return kPulseTooWeak;
  if (focus.strained_diameter_um() <= focus.melted_diameter_um()) return kPulseMelts;
  if (focus.strained_diameter_um() <= focus.spot_diameter_um()) return kPulseTooWeak;
  return focus.melted_diameter_um() < kUmPerMm * crack.diameter_mm ? kCrackConditionMet
                                                                   : kPulseMelts;
}

const MachineLens* LensOf(const FrozenJob& job) {
  return FindLens(job.machine(), job.job().lens().focal_length_mm());
}

/// `energy_mj`: as DistinctEnergies has it.
PulseFocusRecord FocusAt(const FrozenJob& job, const MachineLens& lens,
                         double energy_mj) {
  const double full_mj = job.machine().laser().pulse_energy_mj();
  const double ratio =
      energy_mj > 0 && full_mj > 0 ? std::min(1.0, energy_mj / full_mj) : 1;
  return PulseFocusOf(job.material(), job.optics(), job.machine().laser(), lens, ratio);
}

Warning WeakWarning(const PulseFocusRecord& focus) {
  return MakeWarning(
      WarningCode::kPulseHeat,
      fmt::format(
          "pulses of {:.3g} mJ in front of lens {} are too weak for a crack: {:.0f} "
          "um about the focus reach the thermal strength of the glass, and the "
          "spot is {:.0f} um wide; take a larger laser.pulse_energy_mj",
          focus.pulse_energy_mj(), focus.lens(), focus.strained_diameter_um(),
          focus.spot_diameter_um()));
}

Warning MeltWarning(const PulseFocusRecord& focus, const OpticalValuesRecord& values) {
  return MakeWarning(
      WarningCode::kPulseHeat,
      fmt::format("pulses of {:.3g} mJ in front of lens {} melt {:.0f} um about the "
                  "focus, and {:.0f} um reach the thermal strength, {:.0f} K: the glass "
                  "melts where it should crack; engrave a test grid (intaglio test-grid) "
                  "first, or take another glass or a smaller laser.pulse_energy_mj",
                  focus.pulse_energy_mj(), focus.lens(), focus.melted_diameter_um(),
                  focus.strained_diameter_um(), values.local_thermal_strength_k()));
}

}  // namespace

PulseFocusRecord PulseFocusOf(const MaterialRecord& glass,
                              const OpticalValuesRecord& values, const LaserHead& laser,
                              const MachineLens& lens, double energy_ratio) {
  PulseFocusRecord focus;
  focus.set_lens(lens.name());
  const double split = laser.has_split_ratio() ? laser.split_ratio() : 1;
  const double full_mj = split * laser.pulse_energy_mj();
  focus.set_pulse_energy_mj(energy_ratio * full_mj);
  focus.set_rate_hz(DefaultRateHz(laser));
  AddSpot(laser, lens, focus);
  const bool crack = lens.crack_diameter_mm() > 0 && lens.crack_length_mm() > 0;
  const bool heat = glass.density_kg_m3() > 0 && glass.specific_heat_j_kg_k() > 0 &&
                    glass.conductivity_w_m_k() > 0 &&
                    glass.melting_point_c() > optics::kRoomTemperatureC;
  if (crack && heat && focus.rate_hz() > 0 && full_mj > 0)
    AddHeat(glass, values, lens, full_mj, focus);
  if (crack && glass.youngs_modulus_gpa() > 0 && glass.has_poisson_ratio() &&
      glass.density_kg_m3() > 0) {
    const double waves_m_s = optics::TransverseWaveSpeedMS(
        glass.youngs_modulus_gpa(), glass.poisson_ratio(), glass.density_kg_m3());
    focus.set_crack_growth_s(
        optics::CrackGrowthSeconds(lens.crack_length_mm(), waves_m_s));
  }
  AddUnknown(glass, lens, focus);
  const bool known = focus.has_melted_diameter_um() && focus.has_strained_diameter_um();
  focus.set_condition(known ? ConditionOf(focus, lens, full_mj) : kConditionNotKnown);
  return focus;
}

PulseFocusRecord PulseFocusOf(const FrozenJob& job) {
  const MachineLens* lens = LensOf(job);
  if (lens == nullptr) return {};
  return FocusAt(job, *lens, DistinctEnergies(job.job()).back());
}

std::string CrackConditionText(const PulseFocusRecord& focus) {
  if (focus.condition() == kConditionNotKnown)
    return fmt::format("not known, for want of {}", fmt::join(focus.unknown(), ", "));
  const char* sentence = "met";
  if (focus.condition() == kPulseTooWeak) sentence = "NOT MET, the pulse is too weak";
  if (focus.condition() == kPulseMelts) sentence = "NOT MET, the glass melts";
  return fmt::format(
      "{}: {:.0f} um reach the thermal strength, {:.0f} um the melting point", sentence,
      focus.strained_diameter_um(), focus.melted_diameter_um());
}

Warnings PulseWarningsOf(const FrozenJob& job) {
  const MachineLens* lens = LensOf(job);
  if (lens == nullptr) return {};
  const std::vector<double> energies_mj = DistinctEnergies(job.job());
  Warnings warnings;
  if (const auto weakest = FocusAt(job, *lens, energies_mj.front());
      weakest.condition() == kPulseTooWeak)
    warnings.push_back(WeakWarning(weakest));
  if (const auto strongest = FocusAt(job, *lens, energies_mj.back());
      strongest.condition() == kPulseMelts)
    warnings.push_back(MeltWarning(strongest, job.optics()));
  return warnings;
}

}  // namespace intaglio
