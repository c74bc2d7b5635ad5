#pragma once

// Glasses and their optical values between the material base and what travels.

#include "engrave/core/result.h"
#include "materials_db/material.h"
#include "proto/material.pb.h"

namespace intaglio {

MaterialRecord RecordOf(const materials_db::Material& material);

/// kUnsupported for a dispersion formula that is not known. The values are not checked.
Result<materials_db::Material> MaterialOf(const MaterialRecord& record);

OpticalValuesRecord RecordOf(const materials_db::OpticalValues& values,
                             double wavelength_nm, double numerical_aperture);

}  // namespace intaglio
