#pragma once

// What is wrong with the outputs and inputs of a machine for other uses. Errors name the
// field, its value and the remedy.

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Names and remedies are there, each name and each number is used once, and at most 8 of
/// each kind. A machine that marks has none.
void CheckAccessories(const MachineSpec& machine, std::vector<Error>& errors);

}  // namespace intaglio
