#pragma once

#include <string>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// The stage's way over that of the focus in the glass of this name
/// (engrave/optics/focus.h), with this lens, by the material base in `database`; empty:
/// the user's. Errors: of the base, and kNotFound with the glasses that are nearest in
/// name.
Result<double> StagePerGlassRatio(const std::string& database, const MachineSpec& machine,
                                  const MachineLens& lens, const std::string& glass);

}  // namespace intaglio
