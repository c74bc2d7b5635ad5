#pragma once

// The outline of a job, which a guide laser draws where its points or marks will be made.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/task.pb.h"

namespace intaglio::client {

/// The convex polygon around the points by the first two axes of the job's machine, mm,
/// machine frame: with mirrors, where they aim at each point, beams bent and depth
/// included. At most drivers::kMaxOutlineCorners corners; those of fewer lie within the
/// others. `cloud`: one point or more, as the job makes them. Errors: a point that the
/// axes do not reach.
Result<std::vector<Vec2>> OutlineOfJob(const FrozenJob& job, const PointCloud& cloud);

/// The same around all marks in the field, on a piece at rest; one mark or more. Arcs are
/// followed within 10 um. Errors: a mark of a web, whose place is not known before.
Result<std::vector<Vec2>> OutlineOfMarks(const mark::MarkSet& set);

/// The corners of the upright rectangle around these, one or more.
std::vector<Vec2> RectangleAround(const std::vector<Vec2>& corners_mm);

}  // namespace intaglio::client
