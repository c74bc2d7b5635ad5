#include "engrave/contour/files/gerber_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kShort_mm = 1e-4;
constexpr double kOnLine_mm = 2e-5;
constexpr double kMinArea_mm2 = 1e-9;
// Some seconds and 320 MB.
constexpr std::uint64_t kMaxLinePairs = 40'000'000;

using Node = std::array<std::int64_t, 2>;

Node NodeAt(const Vec2& place) {
  return {std::llround(place.x() * 1e6), std::llround(place.y() * 1e6)};
}

/// Without lines that no layout program means, of rounding: the next begins where the one
/// before ends.
Edges WithoutShort(const Edges& path) {
  Edges rest;
  for (const Edge& edge : path) {
    if (!edge.is_arc() && edge.length_mm < kShort_mm && !rest.empty()) continue;
    rest.push_back(edge);
  }
  if (rest.size() < 3) return path;
  for (std::size_t k = 0; k < rest.size(); ++k) {
    Edge& edge = rest[k];
    const Edge& next = rest[(k + 1) % rest.size()];
    if ((edge.end_mm - next.begin_mm).norm() > 2 * kShort_mm || edge.is_arc()) continue;
    edge = MakeLine(edge.begin_mm, next.begin_mm);
  }
  return rest;
}

/// Lines divided where ends of others lie on them: a line that is run back in parts, or
/// beyond its end and back, is then run back line by line.
Result<Edges> DividedAtEnds(const Edges& path) {
  std::vector<FlatBox> boxes;
  for (const Edge& edge : path) boxes.push_back(FlatBoxOf(edge));
  std::vector<std::vector<std::pair<double, Vec2>>> cuts(path.size());
  const auto cut = [&](std::size_t line, const Vec2& place) {
    const Edge& edge = path[line];
    if (edge.is_arc() || edge.length_mm == 0) return;
    const double way = WayTo(edge, place);
    if (way > kShort_mm && way < edge.length_mm - kShort_mm &&
        DistanceTo(edge, place) < kOnLine_mm)
      cuts[line].emplace_back(way, place);
  };
  const auto pairs = INTAGLIO_TRY(NearPairsUpTo(boxes, kOnLine_mm, kMaxLinePairs));
  for (const Pair& pair : pairs) {
    for (const auto& [line, other] :
         {std::pair(pair.first, pair.second), std::pair(pair.second, pair.first)}) {
      cut(line, path[other].begin_mm);
      cut(line, path[other].end_mm);
    }
  }
  Edges divided;
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (cuts[k].empty()) {
      divided.push_back(path[k]);
      continue;
    }
    std::sort(cuts[k].begin(), cuts[k].end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    Vec2 at = path[k].begin_mm;
    cuts[k].emplace_back(path[k].length_mm, path[k].end_mm);
    for (const auto& [way, place] : cuts[k]) {
      if (NodeAt(place) != NodeAt(at)) divided.push_back(MakeLine(at, place));
      at = place;
    }
  }
  return divided;
}

/// Lines that are not run back.
Edges WithoutCutIns(const Edges& path) {
  std::map<std::pair<Node, Node>, std::vector<std::size_t>> open;
  std::vector<char> left_out(path.size(), 0);
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (path[k].is_arc()) continue;
    const Node begin = NodeAt(path[k].begin_mm);
    const Node end = NodeAt(path[k].end_mm);
    left_out[k] = begin == end;
    if (left_out[k]) continue;
    auto& back = open[{end, begin}];
    if (back.empty()) {
      open[{begin, end}].push_back(k);
      continue;
    }
    left_out[k] = left_out[back.back()] = 1;
    back.pop_back();
  }
  Edges rest;
  for (std::size_t k = 0; k < path.size(); ++k) {
    if (!left_out[k]) rest.push_back(path[k]);
  }
  return rest;
}

}  // namespace

Result<Outline> RegionOutline(const Edges& path) {
  Edges closed = path;
  if (!path.empty() && path.back().end_mm != path.front().begin_mm)
    closed.push_back(MakeLine(path.back().end_mm, path.front().begin_mm));
  const Edges edges = WithoutCutIns(INTAGLIO_TRY(DividedAtEnds(WithoutShort(closed))));
  std::map<Node, std::vector<std::size_t>> begins;
  for (std::size_t k = edges.size(); k-- > 0;)
    begins[NodeAt(edges[k].begin_mm)].push_back(k);
  std::vector<char> used(edges.size(), 0);
  Outline outline;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    outline.loops.emplace_back();
    const Node start = NodeAt(edges[first].begin_mm);
    for (std::size_t k = first;;) {
      used[k] = 1;
      outline.loops.back().push_back(edges[k]);
      const Node end = NodeAt(edges[k].end_mm);
      if (end == start) break;
      auto& next = begins[end];
      while (!next.empty() && used[next.back()]) next.pop_back();
      if (next.empty())
        return Fail(ErrorCode::kInvalidValue,
                    fmt::format("a region is open at ({:.6g}, {:.6g}); close it",
                                edges[k].end_mm.x(), edges[k].end_mm.y()));
      k = next.back();
    }
  }
  std::erase_if(outline.loops,
                [](const Edges& loop) { return std::abs(AreaOf(loop)) < kMinArea_mm2; });
  return outline;
}

}  // namespace intaglio::contour
