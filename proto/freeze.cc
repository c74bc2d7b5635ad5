#include "proto/freeze.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/optics/dispersion.h"
#include "engrave/optics/fresnel.h"
#include "engrave/optics/thermal.h"
#include "proto/job_check.h"
#include "proto/job_defaults.h"

namespace intaglio {
namespace {

Result<double> IndexOf(const MaterialRecord& material, double wavelength_nm) {
  const auto formula = optics::DispersionFormulaFromName(material.dispersion_formula());
  if (!formula) return tl::unexpected(formula.error());
  const optics::Dispersion dispersion{*formula,
                                      {material.dispersion_coefficients().begin(),
                                       material.dispersion_coefficients().end()},
                                      material.min_wavelength_um(),
                                      material.max_wavelength_um()};
  return optics::RefractiveIndex(dispersion, wavelength_nm);
}

bool HasThermalValues(const MaterialRecord& material) {
  return material.has_tensile_strength_mpa() && material.has_poisson_ratio() &&
         material.has_expansion_per_k() && material.has_youngs_modulus_gpa();
}

Error AboutGlass(const MaterialRecord& material, Error error) {
  error.message = fmt::format("glass: {}: {}", material.name(), error.message);
  return error;
}

// The job is fit to be asked for its optics: lens and wavelength are there.
bool HasOptics(const JobSpec& job) {
  return job.laser().wavelength_nm() > 0 && job.lens().numerical_aperture() > 0 &&
         job.lens().numerical_aperture() < 1;
}

}  // namespace

Result<OpticalValuesRecord> OpticalValuesOf(const MaterialRecord& material,
                                            double wavelength_nm,
                                            double numerical_aperture) {
  const auto index = IndexOf(material, wavelength_nm);
  if (!index) return tl::unexpected(AboutGlass(material, index.error()));
  OpticalValuesRecord values;
  values.set_wavelength_nm(wavelength_nm);
  values.set_numerical_aperture(numerical_aperture);
  values.set_refractive_index(*index);
  values.set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(*index, numerical_aperture));
  values.set_cone_tangent(optics::ConeTangentInGlass(*index, numerical_aperture));
  values.set_reflectance_ratio(optics::ReflectanceAtNormalIncidence(*index));
  if (HasThermalValues(material)) {
    values.set_thermal_strength_k(optics::ThermalStrengthK(
        {material.tensile_strength_mpa(), material.poisson_ratio(),
         material.expansion_per_k(), material.youngs_modulus_gpa()}));
  }
  return values;
}

Result<FrozenJob> FreezeJob(const JobSpec& job, const MachineSpec& machine,
                            const MaterialRecord& material, const JobIdentity& identity) {
  const MachineSpec whole_machine = WithMachineDefaults(machine);
  JobSpec whole = WithDefaults(job, whole_machine);
  std::optional<double> ratio;
  std::vector<Error> glass_errors;
  OpticalValuesRecord optics;
  if (HasOptics(whole)) {
    const auto values = OpticalValuesOf(material, whole.laser().wavelength_nm(),
                                        whole.lens().numerical_aperture());
    if (values) {
      optics = *values;
      ratio = values->stage_per_glass_ratio();
    } else {
      glass_errors.push_back(values.error());
    }
  }
  std::vector<Error> errors = CheckAll(job, machine, ratio);
  errors.insert(errors.end(), glass_errors.begin(), glass_errors.end());
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  if (whole.ordering().has_kdz() && !whole.ordering().kdz().has_up_ratio()) {
    whole.mutable_ordering()->mutable_kdz()->set_up_ratio(
        std::max(kLeastUpRatio, optics.cone_tangent()));
  }
  FrozenJob frozen;
  frozen.set_job_uid(identity.uid);
  frozen.set_epoch(identity.epoch);
  *frozen.mutable_job() = std::move(whole);
  *frozen.mutable_machine() = whole_machine;
  *frozen.mutable_material() = material;
  *frozen.mutable_optics() = std::move(optics);
  frozen.set_software_version(identity.software_version);
  frozen.set_result_directory(identity.result_directory);
  return frozen;
}

}  // namespace intaglio
