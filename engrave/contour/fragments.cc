#include "engrave/contour/fragments.h"

#include <algorithm>
#include <cmath>

namespace intaglio::contour {
namespace {

// Nearer than this to an outline it is open which side a point is on, mm.
constexpr double kShallow_mm = 1e-6;

/// Walks along one edge and collects what no cover removes.
class EdgeRemains {
 public:
  EdgeRemains(const Edge& edge, std::uint32_t area, Remains& remains)
      : edge_(edge), area_(area), remains_(remains), place_(edge.begin_mm) {}

  void Remove(const Cover& cover) {
    if (cover.begin_mm - way_ > kVertex_mm)
      AddFragment(cover.begin_mm, cover.begin_place_mm);
    const bool clear =
        cover.kind == CoverKind::kOpposite ||
        (cover.kind == CoverKind::kInside && cover.depth_mm < -kShallow_mm);
    if (!clear) {
      const double middle = 0.5 * (cover.begin_mm + cover.end_mm);
      remains_.omissions.push_back(
          {PointAt(edge_, middle), RightOf(DirectionAt(edge_, middle)), area_});
    }
    if (cover.end_mm <= way_) return;
    way_ = cover.end_mm;
    place_ = cover.end_place_mm;
  }

  void Finish() {
    if (edge_.length_mm - way_ > kVertex_mm) AddFragment(edge_.length_mm, edge_.end_mm);
  }

 private:
  void AddFragment(double end, const Vec2& end_place) {
    remains_.fragments.push_back({PartOf(edge_, way_, end, place_, end_place), area_});
  }

  const Edge& edge_;
  std::uint32_t area_;
  Remains& remains_;
  double way_ = 0;
  Vec2 place_;
};

}  // namespace

Remains RemainsOf(std::span<const Area> areas, const CoverFinder& finder,
                  std::vector<Cover>& covers) {
  std::sort(covers.begin(), covers.end(), [](const Cover& a, const Cover& b) {
    if (a.edge != b.edge) return a.edge < b.edge;
    if (a.begin_mm != b.begin_mm) return a.begin_mm < b.begin_mm;
    return a.other < b.other;
  });
  Remains remains;
  auto cover = covers.begin();
  for (std::uint32_t area = 0; area < areas.size(); ++area) {
    for (std::uint32_t k = 0; k < areas[area].edges.size(); ++k) {
      EdgeRemains edge(areas[area].edges[k], area, remains);
      for (; cover != covers.end() && cover->edge == finder.FirstEdge(area) + k;
           ++cover) {
        if (cover->kind == CoverKind::kSame && cover->other > area) continue;
        edge.Remove(*cover);
      }
      edge.Finish();
    }
  }
  return remains;
}

}  // namespace intaglio::contour
