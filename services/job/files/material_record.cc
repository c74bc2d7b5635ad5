#include "services/job/files/material_record.h"

#include "engrave/core/check.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

// The properties have the same names in the base's table and in the message.
const pb::FieldDescriptor& FieldOf(const materials_db::PropertyRow& row) {
  const auto* field = MaterialRecord::descriptor()->FindFieldByName(row.name);
  Require(field != nullptr, "MaterialRecord has no field {}", row.name);
  return *field;
}

}  // namespace

MaterialRecord RecordOf(const materials_db::Material& material) {
  MaterialRecord record;
  record.set_name(material.name);
  record.set_manufacturer(material.manufacturer);
  record.set_source(material.source);
  const optics::Dispersion& dispersion = material.dispersion;
  record.set_dispersion_formula(optics::DispersionFormulaName(dispersion.formula));
  record.mutable_dispersion_coefficients()->Assign(dispersion.coefficients.begin(),
                                                   dispersion.coefficients.end());
  record.set_min_wavelength_um(dispersion.min_wavelength_um);
  record.set_max_wavelength_um(dispersion.max_wavelength_um);
  for (const materials_db::PropertyRow& row : materials_db::PropertyRows()) {
    const std::optional<double>& value = material.*row.value;
    if (value) record.GetReflection()->SetDouble(&record, &FieldOf(row), *value);
  }
  for (const optics::Transmittance& entry : material.transmittance) {
    TransmittanceRecord& kept = *record.add_transmittance();
    kept.set_wavelength_um(entry.wavelength_um);
    kept.set_ratio(entry.ratio);
    kept.set_thickness_mm(entry.thickness_mm);
  }
  return record;
}

OpticalValuesRecord RecordOf(const materials_db::OpticalValues& values,
                             double wavelength_nm, double numerical_aperture) {
  OpticalValuesRecord record;
  record.set_wavelength_nm(wavelength_nm);
  record.set_numerical_aperture(numerical_aperture);
  record.set_refractive_index(values.refractive_index);
  record.set_stage_per_glass_ratio(values.stage_per_glass_ratio);
  record.set_cone_tangent(values.cone_tangent);
  record.set_reflectance_ratio(values.reflectance_ratio);
  if (values.thermal_strength_k)
    record.set_thermal_strength_k(*values.thermal_strength_k);
  if (values.local_thermal_strength_k)
    record.set_local_thermal_strength_k(*values.local_thermal_strength_k);
  if (values.absorption_per_mm) record.set_absorption_per_mm(*values.absorption_per_mm);
  return record;
}

}  // namespace intaglio
