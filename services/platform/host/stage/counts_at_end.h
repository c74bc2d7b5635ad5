#pragma once

// Where the points of an engraving are (PointCounts of idl/job.idl).

#include "idl/job.h"

namespace intaglio {

/// What is left of them when the engraving has ended: what was to come was not fired, and
/// of what was armed nobody knows whether it was.
inline intaglio_PointCounts AtEnd(intaglio_PointCounts counts) {
  counts.skipped += counts.to_come;
  counts.uncertain += counts.armed;
  counts.to_come = counts.armed = 0;
  return counts;
}

}  // namespace intaglio
