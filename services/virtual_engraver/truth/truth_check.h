#pragma once

// The check of a truth file (proto/truth.proto): ranges of its fields by their rules
// (services/platform/fields), and what its parts have to be together.

#include <vector>

#include "engrave/core/result.h"
#include "proto/truth.pb.h"

namespace intaglio {

/// Every wrong value, each with the path of its field, the value and what is allowed.
/// Empty: the truth can be started. A field that is absent has its default, which is
/// checked beside those that are given (travel_min_mm against travel_max_mm).
std::vector<Error> CheckTruth(const MachineTruth& truth);

}  // namespace intaglio
