#include "services/job/quality/oblique_beams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "services/job/machine/head_over_block.h"
#include "services/job/machine/job_beams.h"
#include "services/job/machine/pulse_energies.h"

namespace intaglio {
namespace {

constexpr double kShallowMm = 5;  // the first depth of the list
constexpr int kDepths = 4;

std::vector<UsableRadii> RadiiBy(const MachineSpec& machine,
                                 const machine::BeamStrength& strength, double depth_mm,
                                 double energy_mj) {
  const double largest_mj = std::max(energy_mj, machine.laser().pulse_energy_mj());
  const double first_mm = std::min(kShallowMm, depth_mm / kDepths);
  std::vector<UsableRadii> radii;
  for (int i = 0; i < kDepths; ++i) {
    const double at_mm =
        std::lerp(first_mm, depth_mm, static_cast<double>(i) / (kDepths - 1));
    radii.push_back({at_mm, strength.UsableRadiusMm(at_mm, energy_mj),
                     strength.UsableRadiusMm(at_mm, largest_mj),
                     strength.DoubleRadiusMm(at_mm)});
  }
  return radii;
}

}  // namespace

std::optional<ObliqueFigures> ObliqueFiguresOf(const FrozenJob& job,
                                               const PointList& points_mm,
                                               std::span<const std::uint32_t> source) {
  const MachineSpec& machine = job.machine();
  if (!machine.has_head_over_block() || points_mm.empty()) return std::nullopt;
  const auto energies = EnergiesOfPoints(job.job(), source);
  if (!energies) return std::nullopt;
  const JobBeams beams(job);
  const machine::BeamStrength& strength = beams.strength();
  const double crack_mj = CrackEnergyMj(machine);
  const double largest_mj = machine.laser().pulse_energy_mj();
  ObliqueFigures figures;
  figures.field_mm = strength.options().field_mm;
  double deepest_mm = 0.1;
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const auto [depth_mm, tangent] = beams.To(points_mm[i]);
    const double ratio = strength.RatioAt(tangent, depth_mm);
    deepest_mm = std::max(deepest_mm, depth_mm);
    figures.weakest_ratio = std::min(figures.weakest_ratio, ratio);
    figures.max_apart_mm =
        std::max(figures.max_apart_mm, strength.ApartMm(tangent, depth_mm));
    if (strength.IsDouble(tangent, depth_mm)) figures.two_foci.Add(points_mm[i]);
    if (largest_mj * ratio < crack_mj) figures.beyond.Add(points_mm[i]);
    if (energies->Of(static_cast<std::uint32_t>(i)) * ratio < crack_mj)
      figures.weak.Add(points_mm[i]);
  }
  figures.needed_energy_mj = crack_mj / figures.weakest_ratio;
  figures.radii =
      RadiiBy(machine, strength, deepest_mm, job.job().laser().pulse_energy_mj());
  return figures;
}

Warnings ObliqueWarningsOf(const FrozenJob& job, const ObliqueFigures& figures) {
  Warnings warnings;
  const double largest_mj = job.machine().laser().pulse_energy_mj();
  if (figures.weak.count > 0) {
    const Vec3& first_mm = figures.weak.first_mm;
    const std::string energy =
        figures.needed_energy_mj <= largest_mj
            ? fmt::format("ask for {:.3g} mJ (laser.pulse_energy_mj)",
                          figures.needed_energy_mj)
            : fmt::format("all of them would need {:.3g} mJ, the laser has {:g}",
                          figures.needed_energy_mj, largest_mj);
    warnings.push_back(MakeWarning(
        WarningCode::kObliqueBeam,
        fmt::format(
            "{} points get no crack, the first at ({:.1f}, {:.1f}, {:.1f}) mm: the beam "
            "is too oblique there, and at {:.1f} mm depth it cracks the glass up to "
            "{:.1f} mm from the axis of the lens; {}, make the piece smaller or less "
            "deep, put it under the middle of the field, or use a telecentric lens",
            figures.weak.count, first_mm.x(), first_mm.y(), first_mm.z(),
            figures.radii.back().depth_mm, figures.radii.back().radius_mm, energy)));
  }
  if (figures.two_foci.count > 0) {
    warnings.push_back(MakeWarning(
        WarningCode::kTwoFoci,
        fmt::format(
            "at {} points the oblique beam has two foci up to {:.2f} mm apart in "
            "depth, both stronger than what lies between them: a crack may begin "
            "at either; at {:.1f} mm depth this is beyond {:.1f} mm from the axis "
            "of the lens",
            figures.two_foci.count, figures.max_apart_mm, figures.radii.back().depth_mm,
            figures.radii.back().double_radius_mm)));
  }
  return warnings;
}

std::vector<std::string> ObliqueNotesOf(const MachineSpec& machine) {
  std::vector<std::string> notes;
  if (!machine.has_head_over_block()) return notes;
  constexpr double kIndex = 1.52, kDepthMm = 60, kMmPerNm = 1e-6;
  const double energy_mj = machine.laser().pulse_energy_mj();
  for (const MachineLens& lens : machine.lenses()) {
    const optics::FocusedBeam beam{kMmPerNm * machine.laser().wavelength_nm(),
                                   lens.numerical_aperture(), kIndex};
    std::string text =
        fmt::format("lens {}: in glass of the index {} and with {:g} mJ it makes cracks",
                    lens.name(), kIndex, energy_mj);
    const char* before = " ";
    const auto strength = BeamStrengthOf(machine, beam, kDepthMm);
    for (const UsableRadii& at : RadiiBy(machine, strength, kDepthMm, energy_mj)) {
      text += fmt::format("{}up to {:.1f} mm from its axis at {:.0f} mm depth", before,
                          at.radius_mm, at.depth_mm);
      before = ", ";
    }
    notes.push_back(std::move(text));
  }
  return notes;
}

}  // namespace intaglio
