#pragma once

#include "idl/job.h"
#include "services/cell/point_ledger.h"

namespace intaglio::cell {

/// Where the points or marks of a job are, as people see it while it is made; at its end
/// with AtEnd (services/platform/host/stage/counts_at_end.h).
inline intaglio_PointCounts CountsOf(const PointLedger& ledger) {
  const auto known = [&ledger](PointState state) {
    return ledger.count(state) - ledger.unknown_count(state);
  };
  intaglio_PointCounts counts{};
  counts.planned = ledger.size();
  counts.made = ledger.count(PointState::kMade);
  counts.missed = ledger.count(PointState::kMissed);
  counts.skipped = known(PointState::kLeftOut);
  counts.to_come = known(PointState::kPlanned) + known(PointState::kSkipped);
  counts.armed = ledger.count(PointState::kArmed);
  counts.uncertain = counts.planned - counts.made - counts.missed - counts.skipped -
                     counts.to_come - counts.armed;
  return counts;
}

}  // namespace intaglio::cell
