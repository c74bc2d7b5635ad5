#pragma once

#include <vector>

#include "engrave/core/result.h"
#include "materials_db/material.h"

namespace intaglio::materials_db {

/// The result of reading a file of glasses: the valid ones, and every error of the others
/// with its place in the file.
struct Imported {
  std::vector<Material> materials;
  std::vector<Error> errors;
};

/// By how much a record's own nd may differ from its formula's. Catalogs round to five
/// digits or more; a larger difference is a slip in a coefficient, and 0.001 shifts the
/// focus by less than a tenth of a per cent.
inline constexpr double kIndexTolerance = 1e-3;

/// Whether the formula agrees with the nd (587.5618 nm) that its record states. True also
/// when the range does not reach that line, or when nd is not above 1: no value.
bool AgreesWithIndex(const optics::Dispersion& dispersion, double nd);

}  // namespace intaglio::materials_db
