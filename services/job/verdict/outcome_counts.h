#pragma once

#include "idl/job.h"
#include "proto/task.pb.h"

namespace intaglio {

/// How many points the outcome of an engraving has of each kind, as the bus has them.
inline intaglio_PointCounts CountsOf(const EngraveOutcome& outcome) {
  intaglio_PointCounts counts{};
  counts.planned = outcome.planned_count();
  counts.made = outcome.made_count();
  counts.missed = outcome.missed_count();
  counts.skipped = outcome.skipped_count();
  counts.uncertain = outcome.uncertain_count();
  return counts;
}

}  // namespace intaglio
