#pragma once

// The allowed values of proto/truth.proto. The comments there have the same values;
// tests/services/virtual_engraver compares them.

#include <span>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/truth.pb.h"

namespace intaglio {

/// Both ends are allowed; NaN and infinities never are. Of a Vector3 each component, of a
/// repeated field each element.
struct TruthRange {
  std::string_view message;  ///< e.g. "TruthStage"
  std::string_view field;
  double min = 0;
  double max = 0;
};
std::span<const TruthRange> TruthRanges();

/// Every wrong value, each with the path of its field, the value and what is allowed.
/// Empty: the truth can be started. A field that is absent has its default, which is
/// checked beside those that are given (travel_min_mm against travel_max_mm).
std::vector<Error> CheckTruth(const MachineTruth& truth);

}  // namespace intaglio
