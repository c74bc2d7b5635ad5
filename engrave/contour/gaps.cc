#include "engrave/contour/gaps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engrave/contour/area.h"
#include "engrave/contour/equal_elements.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kOnEdge_mm = 1e-9;

Vec2 NearestOn(const Edge& edge, const Vec2& point) {
  return PointAt(edge, std::clamp(WayTo(edge, point), 0.0, edge.length_mm));
}

/// The nearest points are an end and what is nearest to it, or lie on a common normal:
/// through the centre of an arc.
class GapFinder {
 public:
  GapFinder(const Edge& first, const Edge& second) {
    for (const Vec2& end : {first.begin_mm, first.end_mm})
      Try(end, NearestOn(second, end));
    for (const Vec2& end : {second.begin_mm, second.end_mm})
      Try(NearestOn(first, end), end);
    if (first.is_arc()) TryNormals(first, second, true);
    if (second.is_arc()) TryNormals(second, first, false);
  }
  EdgeGap gap() const { return gap_; }

 private:
  void Try(const Vec2& on_first, const Vec2& on_second) {
    const double distance = (on_first - on_second).norm();
    if (distance < gap_.distance_mm) gap_ = {distance, on_first, on_second};
  }

  void TryNormals(const Edge& arc, const Edge& other, bool arc_is_first) {
    const Vec2 foot =
        other.is_arc()
            ? other.center_mm
            : other.begin_mm +
                  Along(other) * (arc.center_mm - other.begin_mm).dot(Along(other));
    Vec2 normal = foot - arc.center_mm;
    if (normal.norm() < kOnEdge_mm) return;
    normal.normalize();
    for (const double side : {-1.0, 1.0}) {
      const Vec2 on_arc = arc.center_mm + side * arc.radius_mm * normal;
      if (!IsOn(arc, on_arc)) continue;
      const Vec2 on_other = NearestOn(other, on_arc);
      arc_is_first ? Try(on_arc, on_other) : Try(on_other, on_arc);
    }
  }

  static Vec2 Along(const Edge& line) {
    return (line.end_mm - line.begin_mm) / std::max(line.length_mm, kOnEdge_mm);
  }
  static bool IsOn(const Edge& arc, const Vec2& point) {
    const double way = WayTo(arc, point);
    return way >= 0 && way <= arc.length_mm;
  }

  EdgeGap gap_{std::numeric_limits<double>::infinity(), Vec2::Zero(), Vec2::Zero()};
};

/// The box that whatever is nearer than width_mm to the area reaches into.
FlatBox Around(const Area& area, double width_mm) {
  const Vec2 width = Vec2::Constant(width_mm);
  return {area.min_mm - width, area.max_mm + width};
}

/// Infinite when the areas are farther apart than width_mm.
EdgeGap GapBetween(const Area& first, const Area& second, double width_mm) {
  EdgeGap narrowest{std::numeric_limits<double>::infinity(), Vec2::Zero(), Vec2::Zero()};
  const auto seconds = EdgesNear(second, Around(first, width_mm));
  for (const std::uint32_t a : EdgesNear(first, Around(second, width_mm))) {
    for (const std::uint32_t b : seconds) {
      const EdgeGap gap = GapBetween(first.edges[a], second.edges[b]);
      if (gap.distance_mm < narrowest.distance_mm) narrowest = gap;
    }
  }
  return narrowest;
}

}  // namespace

EdgeGap GapBetween(const Edge& first, const Edge& second) {
  return GapFinder(first, second).gap();
}

Result<std::vector<Gap>> NarrowGaps(std::span<const Element> elements,
                                    std::span<const std::uint32_t> groups,
                                    double width_mm) {
  std::vector<Area> areas;
  const std::vector<std::uint32_t> firsts = FirstsOfEqual(elements);
  for (std::uint32_t k = 0; k < elements.size(); ++k)
    if (firsts[k] == k)
      INTAGLIO_TRY(AppendGrown(elements[k], k, 0, Corners::kRound, areas));
  std::vector<FlatBox> boxes;
  for (const Area& area : areas) boxes.push_back({area.min_mm, area.max_mm});
  std::map<std::pair<std::uint32_t, std::uint32_t>, Gap> narrowest;
  for (const Pair& pair : NearPairs(boxes, width_mm)) {
    const std::uint32_t a = areas[pair.first].element;
    const std::uint32_t b = areas[pair.second].element;
    if (groups[a] == groups[b]) continue;
    const EdgeGap gap = GapBetween(areas[pair.first], areas[pair.second], width_mm);
    if (gap.distance_mm >= width_mm) continue;
    const Gap found{std::min(a, b), std::max(a, b), gap.distance_mm,
                    0.5 * (gap.on_first_mm + gap.on_second_mm)};
    const auto [at, added] =
        narrowest.try_emplace(std::minmax(groups[a], groups[b]), found);
    if (!added && found.width_mm < at->second.width_mm) at->second = found;
  }
  std::vector<Gap> gaps;
  for (const auto& [key, gap] : narrowest) gaps.push_back(gap);
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const Gap& a, const Gap& b) { return a.width_mm < b.width_mm; });
  return gaps;
}

}  // namespace intaglio::contour
