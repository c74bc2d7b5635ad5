#include "engrave/contour/milling/cut_tabs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace intaglio::contour {
namespace {

constexpr double kSlack_mm = 1e-6;

/// Where the middle of a tab may be.
struct Range {
  double begin_mm;
  double end_mm;
};

std::vector<Range> RangesOfTabs(const Edges& path, double length_mm) {
  std::vector<Range> ranges;
  double way = 0;
  for (const Edge& edge : path) {
    if (!edge.is_arc() && edge.length_mm >= length_mm)
      ranges.push_back({way + length_mm / 2, way + edge.length_mm - length_mm / 2});
    way += edge.length_mm;
  }
  return ranges;
}

std::optional<double> LastUpTo(const std::vector<Range>& ranges, double way) {
  for (auto range = ranges.rbegin(); range != ranges.rend(); ++range) {
    if (range->begin_mm <= way) return std::min(range->end_mm, way);
  }
  return std::nullopt;
}

double NearestFrom(const std::vector<Range>& ranges, double wanted, double from,
                   double to) {
  double nearest = to;
  for (const Range& range : ranges) {
    const double begin = std::max(range.begin_mm, from);
    const double end = std::min(range.end_mm, to);
    if (begin > end) continue;
    const double place = std::clamp(wanted, begin, end);
    if (std::abs(place - wanted) < std::abs(nearest - wanted)) nearest = place;
  }
  return nearest;
}

}  // namespace

TabPlaces PlaceTabs(const Edges& path, int count, double length_mm) {
  const std::vector<Range> ranges = RangesOfTabs(path, length_mm);
  const double apart = length_mm + kSlack_mm;
  // From the end on, each as late as possible: the latest place of each.
  std::vector<double> latest;
  double way = std::numeric_limits<double>::infinity();
  while (static_cast<int>(latest.size()) < count) {
    const auto place = LastUpTo(ranges, way);
    if (!place) return {{}, static_cast<int>(latest.size())};
    latest.push_back(*place);
    way = *place - apart;
  }
  TabPlaces places;
  places.max_count = count;
  const double total = LengthOf(path);
  double from = 0;
  for (int k = 0; k < count; ++k) {
    const double last = latest[static_cast<std::size_t>(count - 1 - k)];
    const double wanted = (k + 0.5) / count * total;
    places.ways_mm.push_back(NearestFrom(ranges, wanted, from, last));
    from = places.ways_mm.back() + apart;
  }
  return places;
}

std::vector<CutPiece> DividedAtTabs(const Edges& path, const std::vector<double>& ways_mm,
                                    double length_mm) {
  std::vector<CutPiece> pieces;
  auto tab = ways_mm.begin();
  double before = 0;
  for (const Edge& edge : path) {
    double way = 0;
    Vec2 place = edge.begin_mm;
    const auto append = [&](double to, const Vec2& to_place, bool is_tab) {
      if (to - way > kSlack_mm)
        pieces.push_back({PartOf(edge, way, to, place, to_place), is_tab});
      way = to;
      place = to_place;
    };
    for (; tab != ways_mm.end() && *tab < before + edge.length_mm; ++tab) {
      const double begin = *tab - before - length_mm / 2;
      append(begin, PointAt(edge, std::max(begin, 0.0)), false);
      append(begin + length_mm, PointAt(edge, begin + length_mm), true);
    }
    append(edge.length_mm, edge.end_mm, false);
    before += edge.length_mm;
  }
  return pieces;
}

}  // namespace intaglio::contour
