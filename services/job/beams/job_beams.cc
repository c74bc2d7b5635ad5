#include "services/job/beams/job_beams.h"

#include <algorithm>

#include "engrave/optics/focus.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

constexpr double kMmPerNm = 1e-6;

/// From the middle of the field to its corner, and not above 45 degrees.
double FieldRadiusMm(const MachineSpec& machine, const optics::ScanLens& lens) {
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const Vec2 half_mm =
      travel.min_mm.head<2>().cwiseAbs().cwiseMax(travel.max_mm.head<2>().cwiseAbs());
  return std::min(half_mm.norm(), lens.pupil_mm.minCoeff());
}

optics::FocusedBeam BeamOf(const FrozenJob& job) {
  const double aperture = job.job().lens().numerical_aperture();
  return {kMmPerNm * job.job().laser().wavelength_nm(), aperture,
          optics::RefractiveIndexOf(job.optics().stage_per_glass_ratio(), aperture)};
}

}  // namespace

machine::BeamStrength BeamStrengthOf(const MachineSpec& machine,
                                     const optics::FocusedBeam& beam, double depth_mm) {
  const optics::ScanLens lens = HeadOptionsOf(machine.head_over_block()).lens;
  return machine::BeamStrength(
      {beam, lens, FieldRadiusMm(machine, lens), CrackEnergyMj(machine), depth_mm});
}

JobBeams::JobBeams(const FrozenJob& job)
    : frame_(MachineFromGlassOf(job)),
      strength_(BeamStrengthOf(job.machine(), BeamOf(job), frame_.block_size_mm.z())) {}

JobBeams::Beam JobBeams::To(const Vec3& point_mm) const {
  const Vec2 across_mm = frame_.ToMachine(point_mm).head<2>();
  const double depth_mm = std::max(0.0, frame_.block_size_mm.z() - point_mm.z());
  return {depth_mm, strength_.TangentTo(across_mm, depth_mm)};
}

}  // namespace intaglio
