#include "services/job/quality/oblique_beams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/optics/focus.h"
#include "engrave/optics/oblique_focus.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/pulse_energies.h"

// An oblique beam of the energy E cracks the glass where E times its peak ratio is at
// least the energy that an upright beam needs.

namespace intaglio {
namespace {

constexpr double kMmPerNm = 1e-6;
constexpr double kShallowMm = 5;  // the first depth of the list
constexpr int kDepths = 4;

optics::ScanLens LensOf(const MachineSpec& machine) {
  return HeadOptionsOf(machine.head_over_block()).lens;
}

/// From the middle of the field to its corner, and not above 45 degrees.
double FieldRadiusMm(const MachineSpec& machine) {
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const Vec2 half_mm =
      travel.min_mm.head<2>().cwiseAbs().cwiseMax(travel.max_mm.head<2>().cwiseAbs());
  return std::min(half_mm.norm(), LensOf(machine).pupil_mm.minCoeff());
}

double MaxTangentOf(const MachineSpec& machine) {
  return FieldRadiusMm(machine) / LensOf(machine).pupil_mm.minCoeff();
}

optics::FocusedBeam BeamOf(const FrozenJob& job) {
  const double aperture = job.job().lens().numerical_aperture();
  return {kMmPerNm * job.job().laser().wavelength_nm(), aperture,
          optics::RefractiveIndexOf(job.optics().stage_per_glass_ratio(), aperture)};
}

/// The distance from the axis, at this depth, of a beam of this tangent.
double RadiusMm(const MachineSpec& machine, double index, double depth_mm,
                double tangent) {
  const double pupil_mm = LensOf(machine).pupil_mm.minCoeff();
  const optics::LineFoci foci = optics::FociAtDepth(depth_mm, tangent, index);
  // x = u + h t q / 2, with n h c q = the distance of the foci.
  const double q = foci.tangential_mm / foci.sagittal_mm - 1;
  const double below_mm = foci.sagittal_mm / (index * std::sqrt(1 + q));
  return pupil_mm * tangent + 0.5 * below_mm * tangent * q;
}

/// Where both line foci become the stronger.
double DoubleTangent(const optics::FocusedBeam& beam, double depth_mm,
                     double max_tangent) {
  double low = 0, high = max_tangent;
  const auto is_double = [&](double tangent) {
    return optics::HasTwoStrongFoci(
        beam, optics::FociAtDepth(depth_mm, tangent, beam.refractive_index).apart_mm());
  };
  if (!is_double(high)) return high;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (is_double(middle) ? high : low) = middle;
  }
  return low;
}

std::vector<UsableRadii> RadiiBy(const MachineSpec& machine,
                                 const optics::FocusedBeam& beam,
                                 const optics::ObliqueLoss& loss, double depth_mm,
                                 double energy_mj) {
  const double needed_mj = CrackEnergyMj(machine);
  const double largest_mj = std::max(energy_mj, machine.laser().pulse_energy_mj());
  const double max_tangent = MaxTangentOf(machine);
  const double first_mm = std::min(kShallowMm, depth_mm / kDepths);
  std::vector<UsableRadii> radii;
  for (int i = 0; i < kDepths; ++i) {
    const double at_mm =
        std::lerp(first_mm, depth_mm, static_cast<double>(i) / (kDepths - 1));
    const auto radius_mm = [&](double tangent) {
      return RadiusMm(machine, beam.refractive_index, at_mm, tangent);
    };
    const auto with = [&](double mj) {
      return mj < needed_mj ? 0 : radius_mm(loss.MaxTangent(at_mm, needed_mj / mj));
    };
    radii.push_back({at_mm, with(energy_mj), with(largest_mj),
                     radius_mm(DoubleTangent(beam, at_mm, max_tangent))});
  }
  return radii;
}

/// Depth below the face, and the tangent of the beam to a point.
class BeamsToPoints {
 public:
  explicit BeamsToPoints(const FrozenJob& job)
      : lens_(LensOf(job.machine())),
        frame_(MachineFromGlassOf(job)),
        index_(BeamOf(job).refractive_index) {}

  double DepthMm(const Vec3& point_mm) const {
    return std::max(0.0, frame_.block_size_mm.z() - point_mm.z());
  }
  /// Points that cannot be reached have the tangent 1.
  double TangentTo(const Vec3& point_mm) const {
    const Vec2 across_mm = frame_.ToMachine(point_mm).head<2>();
    const auto solved = optics::PositionFor(
        {across_mm.x(), across_mm.y(), DepthMm(point_mm)}, lens_, index_, 1e-6);
    return solved ? lens_.TangentAt(solved->head.field_mm) : 1;
  }

 private:
  optics::ScanLens lens_;
  optics::MachineFromGlass frame_;
  double index_;
};

}  // namespace

std::vector<UsableRadii> UsableRadiiOf(const MachineSpec& machine,
                                       const optics::FocusedBeam& beam, double depth_mm,
                                       double energy_mj) {
  if (LensOf(machine).is_telecentric()) {
    const double all_mm = energy_mj < CrackEnergyMj(machine) ? 0 : FieldRadiusMm(machine);
    return {{depth_mm, all_mm, FieldRadiusMm(machine), FieldRadiusMm(machine)}};
  }
  return RadiiBy(machine, beam,
                 optics::ObliqueLoss(beam, depth_mm, MaxTangentOf(machine)), depth_mm,
                 energy_mj);
}

std::optional<ObliqueFigures> ObliqueFiguresOf(const FrozenJob& job,
                                               const PointList& points_mm,
                                               std::span<const std::uint32_t> source) {
  const MachineSpec& machine = job.machine();
  if (!machine.has_head_over_block() || points_mm.empty()) return std::nullopt;
  const auto energies = EnergiesOfPoints(job.job(), source);
  if (!energies) return std::nullopt;
  const optics::FocusedBeam beam = BeamOf(job);
  const BeamsToPoints beams(job);
  double deepest_mm = 0.1;
  for (const Vec3& p : points_mm) deepest_mm = std::max(deepest_mm, beams.DepthMm(p));
  ObliqueFigures figures;
  figures.field_mm = FieldRadiusMm(machine);
  figures.needed_energy_mj = CrackEnergyMj(machine);
  const double asked_mj = job.job().laser().pulse_energy_mj();
  if (LensOf(machine).is_telecentric()) {
    figures.radii = UsableRadiiOf(machine, beam, deepest_mm, asked_mj);
  }
  const double max_tangent =
      LensOf(machine).is_telecentric() ? 1e-6 : MaxTangentOf(machine);
  const optics::ObliqueLoss loss(beam, deepest_mm, max_tangent);
  if (figures.radii.empty())
    figures.radii = RadiiBy(machine, beam, loss, deepest_mm, asked_mj);
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const double depth_mm = beams.DepthMm(points_mm[i]);
    const double tangent = beams.TangentTo(points_mm[i]);
    const double ratio = loss.RatioAt(tangent, depth_mm);
    const double apart_mm =
        optics::FociAtDepth(depth_mm, tangent, beam.refractive_index).apart_mm();
    figures.weakest_ratio = std::min(figures.weakest_ratio, ratio);
    figures.max_apart_mm = std::max(figures.max_apart_mm, apart_mm);
    if (optics::HasTwoStrongFoci(beam, apart_mm)) ++figures.double_count;
    if (energies->Of(static_cast<std::uint32_t>(i)) * ratio >= CrackEnergyMj(machine))
      continue;
    if (figures.weak_count++ == 0) figures.first_weak_mm = points_mm[i];
  }
  figures.needed_energy_mj /= figures.weakest_ratio;
  return figures;
}

Warnings ObliqueWarningsOf(const FrozenJob& job, const ObliqueFigures& figures) {
  Warnings warnings;
  const double largest_mj = job.machine().laser().pulse_energy_mj();
  if (figures.weak_count > 0) {
    const Vec3& first_mm = figures.first_weak_mm;
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
            figures.weak_count, first_mm.x(), first_mm.y(), first_mm.z(),
            figures.radii.back().depth_mm, figures.radii.back().radius_mm, energy)));
  }
  if (figures.double_count > 0) {
    warnings.push_back(MakeWarning(
        WarningCode::kTwoFoci,
        fmt::format(
            "at {} points the oblique beam has two foci up to {:.2f} mm apart in "
            "depth, both stronger than what lies between them: a crack may begin "
            "at either; at {:.1f} mm depth this is beyond {:.1f} mm from the axis "
            "of the lens",
            figures.double_count, figures.max_apart_mm, figures.radii.back().depth_mm,
            figures.radii.back().double_radius_mm)));
  }
  return warnings;
}

std::vector<std::string> ObliqueNotesOf(const MachineSpec& machine) {
  std::vector<std::string> notes;
  if (!machine.has_head_over_block()) return notes;
  constexpr double kIndex = 1.52, kDepthMm = 60;
  const double energy_mj = machine.laser().pulse_energy_mj();
  for (const MachineLens& lens : machine.lenses()) {
    const optics::FocusedBeam beam{kMmPerNm * machine.laser().wavelength_nm(),
                                   lens.numerical_aperture(), kIndex};
    std::string text =
        fmt::format("lens {}: in glass of the index {} and with {:g} mJ it makes cracks",
                    lens.name(), kIndex, energy_mj);
    const char* before = " ";
    for (const UsableRadii& at : UsableRadiiOf(machine, beam, kDepthMm, energy_mj)) {
      text += fmt::format("{}up to {:.1f} mm from its axis at {:.0f} mm depth", before,
                          at.radius_mm, at.depth_mm);
      before = ", ";
    }
    notes.push_back(std::move(text));
  }
  return notes;
}

}  // namespace intaglio
