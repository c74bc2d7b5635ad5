#pragma once

#include <atomic>
#include <cstdint>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "services/platform/host/stage/stage_task.h"
#include "services/sorter/order_memo.h"

namespace intaglio::sorter {

/// The cloud in the order of engraving, which `memo` may have, the stage's travel along
/// it, and the shadow violations that the checker (not the sorter) counts. kMissing: the
/// cloud has no points.
Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud, OrderMemo& memo,
                                  std::atomic<std::uint64_t>& estimate_ticks,
                                  const ProgressSink& progress);

/// The marks in the order in which they are made. Errors as of OrderMarks; `progress`
/// counts marks.
Result<host::StageResult> SortMarks(const FrozenJob& job, mark::MarkSet marks,
                                    const ProgressSink& progress);

}  // namespace intaglio::sorter
