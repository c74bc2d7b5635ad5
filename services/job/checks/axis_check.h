#pragma once

// Whether the axes of a profile have what a motion is planned with.

#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// `present`: the profile has the axis. `path`: its field, "x" or "polar.arm", by which
/// the errors name it: kMissing, kInvalidValue for a travel that is none.
void CheckAxis(bool present, const AxisLimits& axis, const std::string& path,
               std::vector<Error>& errors);
void CheckAxis(bool present, const RotaryAxis& axis, const std::string& path,
               std::vector<Error>& errors);

}  // namespace intaglio
