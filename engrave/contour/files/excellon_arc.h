#pragma once

// Arcs of routing in Excellon files.

#include <optional>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// G02 and G03 by the centre, relative to the begin, or by the radius: the shorter of the
/// two arcs. kUnsupported, a sentence without a place: the arc does not exist.
Result<Edge> ExcellonArc(const Vec2& from_mm, const Vec2& to_mm,
                         const std::optional<Vec2>& center_offset_mm,
                         std::optional<double> radius_mm, bool counter_clockwise);

}  // namespace intaglio::contour
