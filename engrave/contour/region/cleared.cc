#include <algorithm>

#include "engrave/contour/near_pairs.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// Common parts with less are the rounding of borders that touch, mm2.
constexpr double kNoArea_mm2 = 1e-7;

FlatBox BoxOfLoops(const Region& region) {
  FlatBox box{Vec2::Constant(1e300), Vec2::Constant(-1e300)};
  for (const Edges& loop : region.loops) {
    const EdgeBox next = BoxOfEdges(loop);
    box = {box.min_mm.cwiseMin(next.min_mm), box.max_mm.cwiseMax(next.max_mm)};
  }
  return box;
}

/// A box around a shape, not always the smallest.
struct Reach {
  static FlatBox About(const Vec2& center, double half) {
    return {center - Vec2::Constant(half), center + Vec2::Constant(half)};
  }
  FlatBox operator()(const Circle& s) const { return About(s.center_mm, s.diameter_mm); }
  FlatBox operator()(const Square& s) const { return About(s.center_mm, s.side_mm); }
  FlatBox operator()(const Octagon& s) const { return About(s.center_mm, s.size_mm); }
  FlatBox operator()(const Track& s) const {
    const Vec2 half = Vec2::Constant(s.width_mm);
    return {s.begin_mm.cwiseMin(s.end_mm) - half, s.begin_mm.cwiseMax(s.end_mm) + half};
  }
  FlatBox operator()(const ArcTrack& s) const {
    return About(s.arc.center_mm, s.arc.radius_mm + s.width_mm);
  }
  FlatBox operator()(const Outline& s) const { return BoxOfLoops({s.loops}); }
};

bool Meet(const FlatBox& a, const FlatBox& b) {
  return (a.min_mm.array() <= b.max_mm.array()).all() &&
         (b.min_mm.array() <= a.max_mm.array()).all();
}

/// The places of pads and tracks stay as they are: what is left of an element ends where
/// that of its neighbour ends.
Status AppendRest(const Element& element, const Region& cleared,
                  std::vector<Element>& rest) {
  const Region whole = RegionOf(INTAGLIO_TRY(Unite({&element, 1}, {0, Corners::kRound})));
  Combined combined = INTAGLIO_TRY(Combine(whole, cleared));
  if (combined.inside_area_mm2 < kNoArea_mm2) {
    rest.push_back(element);
    return {};
  }
  for (Region& part : ConnectedParts(combined.outside)) {
    if (AreaOf(part) > kNoArea_mm2)
      rest.push_back({Outline{std::move(part.loops)}, element.name, element.net});
  }
  return {};
}

}  // namespace

Result<std::vector<Element>> Cleared(std::span<const Element> elements,
                                     std::span<const Element> cleared) {
  const Union hole = INTAGLIO_TRY(Unite(cleared, {0, Corners::kRound}));
  const std::vector<Region> parts = ConnectedParts(RegionOf(hole));
  const FlatBox all = BoxOfLoops(RegionOf(hole));
  std::vector<FlatBox> boxes;
  for (const Region& part : parts) boxes.push_back(BoxOfLoops(part));
  std::vector<std::size_t> reached;  // elements, by their boxes
  for (std::size_t k = 0; k < elements.size(); ++k) {
    const FlatBox box = std::visit(Reach{}, elements[k].shape);
    if (!Meet(box, all)) continue;
    reached.push_back(k);
    boxes.push_back(box);
  }
  std::vector<Region> near(elements.size());
  for (const Pair& pair : NearPairs(boxes, 0)) {
    if (pair.first >= parts.size() || pair.second < parts.size()) continue;
    auto& loops = near[reached[pair.second - parts.size()]].loops;
    const auto& more = parts[pair.first].loops;
    loops.insert(loops.end(), more.begin(), more.end());
  }
  std::vector<Element> rest;
  for (std::size_t k = 0; k < elements.size(); ++k) {
    if (near[k].loops.empty())
      rest.push_back(elements[k]);
    else
      INTAGLIO_TRY(AppendRest(elements[k], near[k], rest));
  }
  return rest;
}

}  // namespace intaglio::contour
