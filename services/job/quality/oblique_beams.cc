#include "services/job/quality/oblique_beams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/beams/job_beams.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/laser_setting.h"

namespace intaglio {
namespace {

constexpr double kShallowMm = 5;  // the first depth of the list
constexpr int kDepths = 4;

std::vector<UsableRadii> RadiiBy(const MachineSpec& machine,
                                 const machine::BeamStrength& strength, double depth_mm,
                                 double energy_mj) {
  const double largest_mj = std::max(energy_mj, SettableEnergies(machine).max_mj);
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
  const auto of_models = EnergiesOfPoints(job.job(), source);
  if (!of_models) return std::nullopt;
  const JobBeams beams(job);
  const machine::BeamStrength& strength = beams.strength();
  const double crack_mj = CrackEnergyMj(machine);
  const double largest_mj = SettableEnergies(machine).max_mj;
  ObliqueFigures figures;
  figures.largest_energy_mj = largest_mj;
  figures.crack_is_measured = machine.head_over_block().has_crack_energy_mj();
  figures.why_one_energy = WhyOneEnergy(job);
  const bool by_place = figures.why_one_energy.empty();
  const PointEnergies energies =
      by_place ? RaisedByPlace(beams, largest_mj, points_mm, *of_models) : *of_models;
  figures.energies_mj = energies.distinct_mj;
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
    const auto point = static_cast<std::uint32_t>(i);
    if (energies.Of(point) * ratio < crack_mj) {
      figures.weak.Add(points_mm[i]);
    } else if (by_place && energies.Of(point) * ratio < of_models->Of(point)) {
      ++figures.limited_count;
    }
  }
  figures.needed_energy_mj = crack_mj / figures.weakest_ratio;
  figures.radii =
      RadiiBy(machine, strength, deepest_mm, job.job().laser().pulse_energy_mj());
  return figures;
}

std::string MaxRadiiText(const ObliqueFigures& figures) {
  std::string text;
  for (const UsableRadii& at : figures.radii) {
    text += fmt::format("{}up to {:.1f} mm from the axis of the lens at {:.0f} mm depth",
                        text.empty() ? "" : ", ", at.max_radius_mm, at.depth_mm);
  }
  return text;
}

Status CheckOblique(const FrozenJob& job, const ObliqueFigures& figures) {
  if (figures.beyond.count == 0 || !figures.crack_is_measured) return {};
  if (!job.job().laser().energy_by_place()) return {};
  const Vec3& first_mm = figures.beyond.first_mm;
  const std::string place =
      fmt::format("({:.1f}, {:.1f}, {:.1f})", first_mm.x(), first_mm.y(), first_mm.z());
  const std::string one_energy =
      figures.why_one_energy.empty()
          ? ""
          : fmt::format(", and its energy does not follow the place: {}",
                        figures.why_one_energy);
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format(
          "{} {} no crack, the first at {} mm: the beam is too oblique there, "
          "and "
          "they need up to {:.3g} mJ. With the {:g} mJ that the laser has there are "
          "cracks "
          "{}{}; make the piece smaller or less deep, put it under the middle of the "
          "field, or use a telecentric lens",
          Counted(figures.beyond.count, "point"),
          VerbFor(figures.beyond.count, "gets", "get"), place, figures.needed_energy_mj,
          figures.largest_energy_mj, MaxRadiiText(figures), one_energy),
      place);
}

Warnings ObliqueWarningsOf(const ObliqueFigures& figures) {
  Warnings warnings;
  if (figures.weak.count > 0) {
    const Vec3& first_mm = figures.weak.first_mm;
    const std::string energy =
        figures.needed_energy_mj <= figures.largest_energy_mj
            ? fmt::format("ask for {:.3g} mJ (laser.pulse_energy_mj)",
                          figures.needed_energy_mj)
            : fmt::format("all of them would need {:.3g} mJ, the laser has {:g}",
                          figures.needed_energy_mj, figures.largest_energy_mj);
    const char* assumed =
        figures.crack_is_measured
            ? ""
            : "; assumed is that an upright beam needs 0.8 of the largest energy: "
              "measure it with `intaglio test-grid`, and give "
              "head_over_block.crack_energy_mj";
    warnings.push_back(MakeWarning(
        WarningCode::kObliqueBeam,
        fmt::format(
            "{} {} no crack, the first at ({:.1f}, {:.1f}, {:.1f}) mm: the beam "
            "is too oblique there, and at {:.1f} mm depth it cracks the glass up to "
            "{:.1f} mm from the axis of the lens; {}, make the piece smaller or less "
            "deep, put it under the middle of the field, or use a telecentric lens{}",
            Counted(figures.weak.count, "point"),
            VerbFor(figures.weak.count, "gets", "get"), first_mm.x(), first_mm.y(),
            first_mm.z(), figures.radii.back().depth_mm, figures.radii.back().radius_mm,
            energy, assumed)));
  }
  if (figures.two_foci.count > 0) {
    warnings.push_back(MakeWarning(
        WarningCode::kTwoFoci,
        fmt::format(
            "at {}, the first at ({:.1f}, {:.1f}, {:.1f}) mm, the oblique beam "
            "has two foci up to {:.2f} mm apart in depth, both stronger than what lies "
            "between them: a crack may begin at either; at {:.1f} mm depth this is "
            "beyond {:.1f} mm from the axis of the lens",
            Counted(figures.two_foci.count, "point"), figures.two_foci.first_mm.x(),
            figures.two_foci.first_mm.y(), figures.two_foci.first_mm.z(),
            figures.max_apart_mm, figures.radii.back().depth_mm,
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
