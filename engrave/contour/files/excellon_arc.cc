#include "engrave/contour/files/excellon_arc.h"

#include <algorithm>
#include <cmath>

namespace intaglio::contour {

Result<Edge> ExcellonArc(const Vec2& from_mm, const Vec2& to_mm,
                         const std::optional<Vec2>& center_offset_mm,
                         std::optional<double> radius_mm, bool counter_clockwise) {
  const Vec2 chord = to_mm - from_mm;
  const double half = chord.norm() / 2;
  Vec2 center = Vec2::Zero();
  if (center_offset_mm) {
    center = from_mm + *center_offset_mm;
  } else if (radius_mm && half > 0 && *radius_mm >= half * (1 - 1e-6)) {
    const double r = *radius_mm;
    const double off = std::sqrt(std::max(0.0, r * r - half * half));
    center = from_mm + chord / 2 +
             RightOf(chord.normalized()) * (counter_clockwise ? -off : off);
  } else {
    return Fail(ErrorCode::kUnsupported,
                "an arc needs its radius A, at least half its chord, or I and J; "
                "export it again");
  }
  const double r = (from_mm - center).norm();
  if (r < 1e-6 || std::abs((to_mm - center).norm() - r) > 0.01 + 1e-3 * r)
    return Fail(
        ErrorCode::kUnsupported,
        "the ends of an arc are not equally far from its centre; export it again");
  return MakeArcBetween(from_mm, to_mm, center, counter_clockwise);
}

}  // namespace intaglio::contour
