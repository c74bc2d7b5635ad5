#pragma once

#include "idl/job.h"
#include "services/cell/point_ledger.h"

namespace intaglio::cell {

/// What became of the points or marks of a job, as people see it.
inline intaglio_PointCounts CountsOf(const PointLedger& ledger) {
  intaglio_PointCounts counts{};
  counts.planned = ledger.size();
  counts.made = ledger.count(PointState::kMade);
  counts.missed = ledger.count(PointState::kMissed);
  counts.skipped = ledger.count(PointState::kSkipped) +
                   ledger.count(PointState::kPlanned) +
                   ledger.count(PointState::kLeftOut) - ledger.unknown_count();
  counts.uncertain = ledger.count(PointState::kUncertain) +
                     ledger.count(PointState::kArmed) + ledger.unknown_count();
  return counts;
}

}  // namespace intaglio::cell
