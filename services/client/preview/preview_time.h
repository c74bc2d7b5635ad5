#pragma once

// The machining time of a cloud that is not ordered yet. Up to kOwnOrderPoints the points
// get the order that the job asks for; beyond that the quick order `smooth` takes the
// place of `anneal`, which would save another 0.2 % of the ticks on a bunny of 277 000
// points, and up to 3 % where steps are irregular. Beyond `max_planned_points` eight
// compact pieces from all over the cloud are ordered and planned, and the time of all
// points is that of the middle halves of the pieces times the ratio of the points: within
// a piece points have the neighbours that they have in the whole, so the steps are as
// long, and at its ends it comes from rest and to it, as the whole does once. Pieces of
// an order of slabs are slices, four times as large.

#include <cstdint>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "proto/preview.pb.h"
#include "proto/task.pb.h"

namespace intaglio::client {

inline constexpr std::size_t kOwnOrderPoints = 30'000;

struct CloudToTime {
  const PointList& points_mm;             ///< glass frame, from the lowest up; not empty
  const std::vector<ChannelMask>& masks;  ///< one a point
};

/// Errors: a place out of the reach or travel of the machine's axes, those of MakeOrder,
/// kCancelled.
Result<TimePreview> EstimateTime(const FrozenJob& job, const CloudToTime& cloud,
                                 std::size_t max_planned_points, const Executor& executor,
                                 const ProgressSink& progress);

}  // namespace intaglio::client
