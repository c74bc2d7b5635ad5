#pragma once

#include "engrave/core/geometry.h"
#include "engrave/core/warning.h"
#include "proto/task.pb.h"

namespace intaglio {

/// A note when the focus at the deepest point is spread over more than the length of a
/// crack of the lens (engrave/optics/focus.h); else, and where lens or index are not
/// known, nothing. Points in the glass frame, mm.
Warnings FocusSpreadOf(const FrozenJob& job, const PointList& points_mm);

}  // namespace intaglio
