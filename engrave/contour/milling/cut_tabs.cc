#include "engrave/contour/milling/cut_tabs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engrave/core/counted.h"

namespace intaglio::contour {
namespace {

constexpr double kSlack_mm = 1e-6;

/// Where the middle of a tab may be.
struct Range {
  double begin_mm;
  double end_mm;
  double length_mm;  ///< of a tab in it
};

enum class TabEdges { kLines, kLinesAndArcs };

/// Along an edge, of a tab whose ends are that far apart; nothing where it holds none.
std::optional<double> TabLengthOn(const Edge& edge, double ends_apart_mm,
                                  TabEdges edges) {
  double length_mm = ends_apart_mm;
  if (edge.is_arc()) {
    if (edges == TabEdges::kLines || edge.radius_mm < ends_apart_mm) return {};
    length_mm = 2 * edge.radius_mm * std::asin(ends_apart_mm / (2 * edge.radius_mm));
  }
  if (edge.length_mm < length_mm) return {};
  return length_mm;
}

std::vector<Range> RangesOfTabs(const Edges& path, double ends_apart_mm, TabEdges edges) {
  std::vector<Range> ranges;
  double way = 0;
  for (const Edge& edge : path) {
    if (const auto length_mm = TabLengthOn(edge, ends_apart_mm, edges)) {
      ranges.push_back(
          {way + *length_mm / 2, way + edge.length_mm - *length_mm / 2, *length_mm});
    }
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

TabPlace NearestFrom(const std::vector<Range>& ranges, double wanted, double from,
                     double to) {
  TabPlace nearest{std::numeric_limits<double>::infinity(), 0};
  from = std::min(from, to);  // `to` is a place of its own, whatever rounding says
  for (const Range& range : ranges) {
    const double begin = std::max(range.begin_mm, from);
    const double end = std::min(range.end_mm, to);
    if (begin > end) continue;
    const double place = std::clamp(wanted, begin, end);
    if (std::abs(place - wanted) < std::abs(nearest.way_mm - wanted))
      nearest = {place, range.length_mm};
  }
  return nearest;
}

TabPlaces PlaceIn(const std::vector<Range>& ranges, int count, double total_mm) {
  double apart = 0;
  for (const Range& range : ranges) apart = std::max(apart, range.length_mm + kSlack_mm);
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
  double from = 0;
  for (int k = 0; k < count; ++k) {
    const double last = latest[static_cast<std::size_t>(count - 1 - k)];
    const double wanted = (k + 0.5) / count * total_mm;
    places.tabs.push_back(NearestFrom(ranges, wanted, from, last));
    from = places.tabs.back().way_mm + apart;
  }
  return places;
}

int TabCountOf(const Edges& path, const TabOptions& options) {
  if (!options.distance_mm) return options.count;
  // One part in a million more of a distance needs no further tab.
  return static_cast<int>(std::ceil(LengthOf(path) / *options.distance_mm - 1e-6));
}

}  // namespace

TabPlaces PlaceTabs(const Edges& path, int count, double ends_apart_mm) {
  const double total_mm = LengthOf(path);
  TabPlaces places =
      PlaceIn(RangesOfTabs(path, ends_apart_mm, TabEdges::kLines), count, total_mm);
  if (places.max_count >= count) return places;
  return PlaceIn(RangesOfTabs(path, ends_apart_mm, TabEdges::kLinesAndArcs), count,
                 total_mm);
}

std::vector<CutPiece> DividedAtTabs(const Edges& path,
                                    const std::vector<TabPlace>& tabs) {
  std::vector<CutPiece> pieces;
  auto tab = tabs.begin();
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
    for (; tab != tabs.end() && tab->way_mm < before + edge.length_mm; ++tab) {
      const double begin = tab->way_mm - before - tab->length_mm / 2;
      const double end = begin + tab->length_mm;
      append(begin, PointAt(edge, std::max(begin, 0.0)), false);
      append(end, PointAt(edge, end), true);
    }
    append(edge.length_mm, edge.end_mm, false);
    before += edge.length_mm;
  }
  return pieces;
}

Result<std::vector<CutPiece>> PiecesWithTabs(const Edges& path, const TabOptions& options,
                                             double tool_diameter_mm) {
  const int count = TabCountOf(path, options);
  // The tool's edge is half its diameter ahead of its centre.
  const TabPlaces places = PlaceTabs(path, count, options.width_mm + tool_diameter_mm);
  if (places.max_count >= count) return DividedAtTabs(path, places.tabs);
  const Vec2& begin = path.front().begin_mm;
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("the lines and wide arcs of the contour at ({:.4g}, {:.4g}) "
                  "hold {} of {} of {:.4g} mm; use fewer or narrower ones",
                  begin.x(), begin.y(), places.max_count,
                  Counted(static_cast<std::uint64_t>(count), "tab"), options.width_mm),
      fmt::format("{:.6g}, {:.6g}", begin.x(), begin.y()));
}

}  // namespace intaglio::contour
