#pragma once

// Corrections of a field inside a message: the contents of a correction file, for a job
// that is frozen.

#include "engrave/core/result.h"
#include "engrave/galvo/field_grid.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Rounded to nanometres. `grid` with its middle node at the origin, as that of each kind
/// of correction file.
FieldTable FieldTableOf(const galvo::FieldGrid& grid);

/// kInvalidValue: another count of numbers than nodes_a_side squared.
Result<galvo::FieldGrid> GridOf(const FieldTable& table);

}  // namespace intaglio
