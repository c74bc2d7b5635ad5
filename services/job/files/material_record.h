#pragma once

// Glasses and their optical values of the material base as messages.

#include "materials_db/material.h"
#include "proto/material.pb.h"

namespace intaglio {

MaterialRecord RecordOf(const materials_db::Material& material);

OpticalValuesRecord RecordOf(const materials_db::OpticalValues& values,
                             double wavelength_nm, double numerical_aperture);

}  // namespace intaglio
