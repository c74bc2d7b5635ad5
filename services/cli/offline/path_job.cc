#include "services/cli/offline/path_job.h"

#include <fmt/format.h>

#include "engrave/core/try.h"
#include "engrave/motion/axis/limits.h"
#include "services/cli/job/job_glass.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/fields/shapes.h"
#include "services/job/files/material_record.h"
#include "services/job/machine/machine_defaults.h"

namespace intaglio::cli {
namespace {

// A point on the face of the block, but for rounding, is in it.
constexpr double kOnFaceMm = 1e-9;

Result<OpticalValuesRecord> OpticsOf(JobAndMachine& job,
                                     const std::string& materials_db) {
  const auto material = INTAGLIO_TRY(FindGlass(job, materials_db));
  const double wavelength_nm = job.job.laser().wavelength_nm();
  const double numerical_aperture = job.job.lens().numerical_aperture();
  const auto optics = INTAGLIO_TRY(
      materials_db::ComputeOptics(material, wavelength_nm, numerical_aperture));
  return intaglio::RecordOf(optics, wavelength_nm, numerical_aperture);
}

}  // namespace

Result<FrozenJob> BuildPathJob(const JobFlags& flags, const PointList& points_mm,
                               const std::string& materials_db) {
  auto built = INTAGLIO_TRY(BuildJobOfPoints(flags, points_mm));
  const auto optics = INTAGLIO_TRY(OpticsOf(built, materials_db));
  // Again, now that it is known from the glass how much travel the block's depth takes.
  const auto errors =
      CheckJobOnMachine(built.job, built.machine, optics.stage_per_glass_ratio());
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  FrozenJob frozen;
  *frozen.mutable_machine() = WithMachineDefaults(built.machine);
  *frozen.mutable_job() = WithDefaults(built.job, frozen.machine());
  *frozen.mutable_optics() = optics;
  return frozen;
}

void ForgetTravel(MachineSpec& machine) {
  std::vector<AxisLimits*> linear = {machine.mutable_z()};
  if (machine.has_polar()) {
    PolarKinematics& polar = *machine.mutable_polar();
    for (RotaryAxis* axis : {polar.mutable_arm(), polar.mutable_table()}) {
      axis->set_travel_min_rad(-motion::kUnlimited);
      axis->set_travel_max_rad(motion::kUnlimited);
    }
  } else {
    linear.insert(linear.end(), {machine.mutable_x(), machine.mutable_y()});
  }
  for (AxisLimits* axis : linear) {
    axis->set_travel_min_mm(-motion::kUnlimited);
    axis->set_travel_max_mm(motion::kUnlimited);
  }
}

Status RequireInBlock(const FrozenJob& job, const PointList& points_mm) {
  const Vec3 size_mm = BlockSizeOf(job.job());
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const Vec3& p = points_mm[i];
    if ((p.array() >= -kOnFaceMm).all() && (p - size_mm).maxCoeff() <= kOnFaceMm) {
      continue;
    }
    const std::string place = fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z());
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format(
            "--path: point {} at {} mm is outside the block of {:g} x {:g} x {:g} mm, "
            "whose corner is at zero; give the --block that the path was made for, or "
            "--frame machine if the points are positions of the stage",
            i, place, size_mm.x(), size_mm.y(), size_mm.z()),
        place);
  }
  return {};
}

}  // namespace intaglio::cli
