#pragma once

#include <cstddef>

#include "engrave/core/result.h"

namespace intaglio::discretize {

/// Maximum number of candidates of a job, before thinning. Far above what a machine
/// engraves (2 million points, Trochimczuk 2008 ch. 1) with the oversampling of the fill,
/// and about 1.5 GB.
inline constexpr std::size_t kMaxCandidates = 50'000'000;

/// kTooLarge when there are, or would be, more candidates than that.
Status CheckCandidateCount(double count);

}  // namespace intaglio::discretize
