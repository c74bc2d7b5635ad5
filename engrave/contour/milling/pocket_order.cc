// A path at b from the wall lies beside one at a < b when some of its points are b - a
// from that one. Each edge of a path is as far from one edge or corner of the wall, all
// along; so the middles and the ends of edges find all paths that it lies beside.
#include "engrave/contour/milling/pocket_order.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "engrave/contour/contour_order.h"
#include "engrave/contour/edge_tree.h"
#include "engrave/contour/region/region_index.h"

namespace intaglio::contour {
namespace {

// Roundings of passes that are made from one another are below 0.02 um.
constexpr double kBesideMm = 1e-4;
// A place as near to a corner is the corner.
constexpr double kCornerMm = 1e-6;

struct PocketNode {
  const Edges* path = nullptr;
  std::uint32_t pass = 0;
  EdgeBox box;
  std::vector<std::uint32_t> towards_wall;  ///< beside it, nearer to the wall
  int deeper_left = 0;                      ///< beside it, and not made
  bool made = false;
};

double DistanceToBox(const EdgeBox& box, const Vec2& place) {
  const Vec2 outside =
      (box.min_mm - place).cwiseMax(place - box.max_mm).cwiseMax(Vec2::Zero());
  return outside.norm();
}

bool LiesWithin(const Edges& path, const EdgeBox& box, const EdgeTree& other,
                double distance_mm) {
  for (const Edge& edge : path) {
    for (const double part : {0.5, 0.0}) {
      const Vec2 place = PointAt(edge, part * edge.length_mm);
      if (DistanceToBox(box, place) <= distance_mm &&
          other.DistanceTo(place) <= distance_mm)
        return true;
    }
  }
  return false;
}

struct Entry {
  std::uint32_t node = 0;
  ContourVisit visit;
  double distance_mm = std::numeric_limits<double>::infinity();
};

void TakeNearer(const PocketNode& node, std::uint32_t number, const Vec2& from,
                Entry& best) {
  if (DistanceToBox(node.box, from) >= best.distance_mm) return;
  const Edges& path = *node.path;
  for (std::uint32_t k = 0; k < path.size(); ++k) {
    const double length = path[k].length_mm;
    double way = WayTo(path[k], from);
    // Beyond an end: that is the begin of this edge or of the next one.
    if (way < kCornerMm || way > length - kCornerMm) way = 0;
    const double distance = (PointAt(path[k], way) - from).norm();
    if (distance < best.distance_mm) best = {number, {0, k, way}, distance};
  }
}

class PocketOrder {
 public:
  explicit PocketOrder(const Pocket& pocket) : pocket_(pocket) {
    for (std::uint32_t pass = 0; pass < pocket.passes.size(); ++pass) {
      first_of_pass_.push_back(static_cast<std::uint32_t>(nodes_.size()));
      for (const Edges& path : pocket.passes[pass].paths)
        nodes_.push_back({&path, pass, BoxOfEdges(path), {}, 0, false});
    }
    first_of_pass_.push_back(static_cast<std::uint32_t>(nodes_.size()));
    for (std::uint32_t pass = 0; pass < pocket.passes.size(); ++pass) FindBeside(pass);
  }

  std::vector<PocketStep> Run(const Vec2& start_mm) {
    std::vector<PocketStep> steps;
    Vec2 at = start_mm;
    const PocketNode* before = nullptr;
    while (steps.size() < nodes_.size()) {
      const Entry next = NextFrom(before, at);
      PocketNode& node = nodes_[next.node];
      steps.push_back({EdgesFrom(*node.path, next.visit), node.pass});
      at = steps.back().path.back().end_mm;
      node.made = true;
      for (const std::uint32_t other : node.towards_wall) --nodes_[other].deeper_left;
      before = &node;
    }
    return steps;
  }

 private:
  /// The deeper paths that those of a pass lie beside. Passes are ordered from the
  /// deepest one on; those put in between may be missing in places, so the one before
  /// them counts as well. One tree is kept at a time.
  void FindBeside(std::uint32_t pass) {
    const double beside_mm = kBesideMm + pocket_.tolerance_mm;
    for (std::uint32_t k = first_of_pass_[pass]; k < first_of_pass_[pass + 1]; ++k) {
      const EdgeTree tree(*nodes_[k].path);
      for (std::uint32_t deep = FirstBeside(pass); deep < first_of_pass_[pass]; ++deep) {
        const double apart_mm =
            pocket_.passes[nodes_[deep].pass].offset_mm - pocket_.passes[pass].offset_mm;
        if (!LiesWithin(*nodes_[deep].path, nodes_[k].box, tree, apart_mm + beside_mm))
          continue;
        nodes_[deep].towards_wall.push_back(k);
        ++nodes_[k].deeper_left;
      }
    }
  }

  /// The first node of the deepest pass that paths of this one may lie beside.
  std::uint32_t FirstBeside(std::uint32_t pass) const {
    std::uint32_t deepest = pass > 0 ? pass - 1 : 0;
    while (deepest > 0 && pocket_.passes[deepest].between) --deepest;
    return first_of_pass_[deepest];
  }

  Entry NextFrom(const PocketNode* before, const Vec2& at) const {
    Entry best;
    if (before != nullptr) {
      for (const std::uint32_t k : before->towards_wall) {
        if (nodes_[k].deeper_left == 0 && !nodes_[k].made)
          TakeNearer(nodes_[k], k, at, best);
      }
      if (best.distance_mm < std::numeric_limits<double>::infinity()) return best;
    }
    for (std::uint32_t k = 0; k < nodes_.size(); ++k) {
      if (nodes_[k].deeper_left == 0 && !nodes_[k].made)
        TakeNearer(nodes_[k], k, at, best);
    }
    return best;
  }

  const Pocket& pocket_;
  std::vector<PocketNode> nodes_;
  std::vector<std::uint32_t> first_of_pass_;
};

}  // namespace

std::vector<PocketStep> OrderPocket(const Pocket& pocket, const Vec2& start_mm) {
  return PocketOrder(pocket).Run(start_mm);
}

}  // namespace intaglio::contour
