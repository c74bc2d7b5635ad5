#pragma once

// The inverse of RecordOf (services/job/files/material_record.h): tests compare what a
// message has with the glass it was made of.

#include "materials_db/material.h"
#include "proto/material.pb.h"

namespace intaglio {

/// Makes it of a record with a dispersion formula that is known.
inline materials_db::Material MaterialOf(const MaterialRecord& record) {
  materials_db::Material material;
  material.name = record.name();
  material.manufacturer = record.manufacturer();
  material.source = record.source();
  material.dispersion = {
      optics::DispersionFormulaFromName(record.dispersion_formula()).value(),
      {record.dispersion_coefficients().begin(), record.dispersion_coefficients().end()},
      record.min_wavelength_um(),
      record.max_wavelength_um()};
  for (const materials_db::PropertyRow& row : materials_db::PropertyRows()) {
    const auto* field = MaterialRecord::descriptor()->FindFieldByName(row.name);
    if (record.GetReflection()->HasField(record, field)) {
      material.*row.value = record.GetReflection()->GetDouble(record, field);
    }
  }
  for (const TransmittanceRecord& entry : record.transmittance())
    material.transmittance.push_back(
        {entry.wavelength_um(), entry.ratio(), entry.thickness_mm()});
  return material;
}

}  // namespace intaglio
