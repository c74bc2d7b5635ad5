#include "engrave/post/lathe_reach.h"

#include <fmt/format.h>

#include <numbers>

namespace intaglio::post {
namespace {

constexpr double kDegreesPerRad = 180 / std::numbers::pi;

}  // namespace

Status RequireReachableOnLathe(std::span<const ToolPath> paths, const Vec2& axis_mm,
                               double speed_mm_s, double limit_deg_s) {
  for (const ToolPath& path : paths) {
    for (contour::Edge edge : EdgesOf(path)) {
      for (Vec2* place : {&edge.begin_mm, &edge.end_mm, &edge.center_mm}) {
        *place -= axis_mm;
      }
      const double needed = AxisSpeed_rad_s(edge, speed_mm_s) * kDegreesPerRad;
      if (needed <= limit_deg_s) continue;
      const double near_mm = contour::DistanceTo(edge, Vec2::Zero());
      return Fail(
          ErrorCode::kUnsupported,
          fmt::format("{} passes the turning axis at {:.4g} mm, which needs {:.4g} deg/s "
                      "at {:.4g} mm/s, and the axis has {:.4g}; reduce the speed to "
                      "{:.3g} mm/s, or move the work away from the axis",
                      path.name, near_mm, needed, speed_mm_s, limit_deg_s,
                      speed_mm_s * limit_deg_s / needed),
          fmt::format("{:.6g}", needed));
    }
  }
  return {};
}

}  // namespace intaglio::post
