#pragma once

// Which contours the turning axis of a lathe can follow. Frame: drawing, mm.

#include <span>

#include "engrave/core/result.h"
#include "engrave/post/tool_path.h"

namespace intaglio::post {

/// Names the path for which an axis at axis_mm has to turn faster than the limit: near
/// the axis TRANSMIT needs w = v / rho (Siwiec 2016 had to leave such a contour out).
Status RequireReachableOnLathe(std::span<const ToolPath> paths, const Vec2& axis_mm,
                               double speed_mm_s, double limit_deg_s);

}  // namespace intaglio::post
