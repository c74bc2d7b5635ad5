#include "services/job/files/freeze.h"

#include <fmt/format.h>

#include "engrave/sort/kdz.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/options.h"
#include "services/job/convert/rows.h"
#include "services/job/files/material_record.h"
#include "services/job/machine/machine_defaults.h"

namespace intaglio {
namespace {

Result<OpticalValuesRecord> OpticsOf(const JobSpec& job,
                                     const materials_db::Material& material) {
  const double wavelength_nm = job.laser().wavelength_nm();
  const double numerical_aperture = job.lens().numerical_aperture();
  const auto values =
      materials_db::ComputeOptics(material, wavelength_nm, numerical_aperture);
  if (!values) {
    Error error = values.error();
    error.message = "glass: " + error.message;
    return tl::unexpected(error);
  }
  return RecordOf(*values, wavelength_nm, numerical_aperture);
}

FrozenJob FrozenFor(const JobIdentity& identity, JobSpec whole,
                    const MachineSpec& machine) {
  FrozenJob frozen;
  frozen.set_job_uid(identity.uid);
  frozen.set_epoch(identity.epoch);
  frozen.set_software_version(identity.software_version);
  frozen.set_result_directory(identity.result_directory);
  *frozen.mutable_job() = std::move(whole);
  *frozen.mutable_machine() = machine;
  return frozen;
}

}  // namespace

Result<FrozenJob> FreezeMarkJob(const JobSpec& job, const MachineSpec& machine,
                                const JobIdentity& identity) {
  const MachineSpec whole_machine = WithMachineDefaults(machine);
  const JobSpec whole = WithMarkDefaults(job);
  const std::vector<Finding> errors = CheckAll(job, whole_machine);
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return FrozenFor(identity, whole, whole_machine);
}

Result<FrozenJob> FreezeJob(const JobSpec& job, const MachineSpec& machine,
                            const materials_db::Material& material,
                            const JobIdentity& identity) {
  const MachineSpec whole_machine =
      ForWavelengthOf(job.laser(), WithMachineDefaults(machine));
  JobSpec whole = WithDefaults(job, whole_machine);
  const auto optics = OpticsOf(whole, material);
  std::vector<Finding> errors =
      CheckAll(job, whole_machine,
               optics ? std::optional(optics->stage_per_glass_ratio()) : std::nullopt);
  if (!optics) errors.push_back(optics.error());
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  FrozenJob frozen = FrozenFor(identity, std::move(whole), whole_machine);
  frozen.mutable_job()->set_glass(material.name);  // it may have been named otherwise
  *frozen.mutable_material() = RecordOf(material);
  *frozen.mutable_optics() = *optics;
  Ordering& ordering = *frozen.mutable_job()->mutable_ordering();
  if (ordering.has_boustrophedon() && !ordering.boustrophedon().has_row_turn_deg()) {
    ordering.mutable_boustrophedon()->set_row_turn_deg(DefaultRowTurnDeg(frozen));
  }
  if (ordering.has_kdz() && !ordering.kdz().has_up_ratio()) {
    ordering.mutable_kdz()->set_up_ratio(sort::DefaultUpRatio(BeamConeOf(frozen)));
  }
  return frozen;
}

}  // namespace intaglio
