#include "engrave/contour/files/gerber_region.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace intaglio::contour {
namespace {

using Node = std::array<std::int64_t, 2>;

Node NodeAt(const Vec2& place) {
  return {std::llround(place.x() * 1e6), std::llround(place.y() * 1e6)};
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
  const Edges edges = WithoutCutIns(path);
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
  if (outline.loops.empty())
    return Fail(ErrorCode::kInvalidValue, "a region has no area; remove it");
  return outline;
}

}  // namespace intaglio::contour
