#include "engrave/contour/milling/nets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "engrave/contour/area.h"
#include "engrave/contour/gaps.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/groups.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr std::uint32_t kNoIsland = UINT32_MAX;
// Places of the copper of a pad without any at its centre are tried so far inside.
constexpr double kInside_mm = 0.01;

struct Island {
  RegionIndex index;
  EdgeBox box;
};

class Islands {
 public:
  explicit Islands(std::span<const Region> copper) {
    for (const Region& layer : copper) {
      begins_.push_back(static_cast<std::uint32_t>(islands_.size()));
      for (const Region& part : ConnectedParts(layer))
        islands_.push_back({RegionIndex(part), BoxOfEdges(part.loops[0])});
    }
    begins_.push_back(static_cast<std::uint32_t>(islands_.size()));
    groups_ = Groups(islands_.size());
  }

  std::uint32_t At(std::uint32_t layer, const Vec2& place) const {
    for (std::uint32_t k = begins_[layer]; k < begins_[layer + 1]; ++k) {
      const Island& island = islands_[k];
      if ((place.array() >= island.box.min_mm.array()).all() &&
          (place.array() <= island.box.max_mm.array()).all() &&
          island.index.IsInside(place))
        return k;
    }
    return kNoIsland;
  }
  std::uint32_t LayerCount() const {
    return static_cast<std::uint32_t>(begins_.size() - 1);
  }
  std::uint32_t Count() const { return begins_.back(); }

  std::uint32_t Conductor(std::uint32_t island) { return groups_.Find(island); }
  void Connect(std::uint32_t a, std::uint32_t b) { groups_.Join(a, b); }

 private:
  std::vector<Island> islands_;
  std::vector<std::uint32_t> begins_;  ///< of each layer
  Groups groups_{0};
};

/// An element's areas, and places where it may have copper: the middles of its areas and
/// points a little inside of their borders.
struct Extent {
  std::vector<Area> areas;
  std::vector<Vec2> places;
};

Result<Extent> ExtentOf(const NetElement& drawn) {
  Extent extent;
  const std::vector<Element> rounded = INTAGLIO_TRY(Rounded({&drawn.element, 1}));
  INTAGLIO_TRY(AppendGrown(rounded[0], 0, 0, Corners::kRound, extent.areas));
  for (const Area& area : extent.areas) {
    if (!area.core_mm.empty())
      extent.places.push_back(
          std::accumulate(area.core_mm.begin(), area.core_mm.end(), Vec2(0, 0)) /
          static_cast<double>(area.core_mm.size()));
  }
  for (const Area& area : extent.areas) {
    for (const Edge& edge : area.edges) {
      for (const double part : {0.125, 0.375, 0.5, 0.625, 0.875}) {
        const double way = part * edge.length_mm;
        extent.places.push_back(PointAt(edge, way) -
                                kInside_mm * RightOf(DirectionAt(edge, way)));
      }
    }
  }
  return extent;
}

/// The nearest points of two elements, in their middle.
EdgeGap Nearest(const Extent& a, const Extent& b) {
  EdgeGap nearest{1e300, Vec2::Zero(), Vec2::Zero()};
  for (const Area& p : a.areas) {
    for (const Area& q : b.areas) {
      for (const Edge& e : p.edges) {
        // What lies inside the other touches it there.
        if (Depth(q, e.begin_mm) < 0) return {0, e.begin_mm, e.begin_mm};
        for (const Edge& f : q.edges) {
          const EdgeGap gap = GapBetween(e, f);
          if (gap.distance_mm < nearest.distance_mm) nearest = gap;
        }
      }
      if (Depth(p, q.edges.front().begin_mm) < 0)
        return {0, q.edges.front().begin_mm, q.edges.front().begin_mm};
    }
  }
  return nearest;
}

std::string NameOf(const NetElement& drawn) {
  return drawn.element.name.empty() ? Describe(drawn.element) : drawn.element.name;
}

class Comparison {
 public:
  Comparison(std::span<const Region> copper, std::span<const NetElement> drawn)
      : islands_(copper), drawn_(drawn) {}

  Result<NetReport> Run() {
    for (std::uint32_t k = 0; k < drawn_.size(); ++k) INTAGLIO_TRY(Place(k));
    for (std::uint32_t k = 0; k < drawn_.size(); ++k) {
      if (conductor_[k] != kNoIsland) conductor_[k] = islands_.Conductor(conductor_[k]);
    }
    CountIslands();
    FindShorts();
    FindOpens();
    std::stable_sort(report_.faults.begin(), report_.faults.end(),
                     [](const NetFault& a, const NetFault& b) { return a.net < b.net; });
    return std::move(report_);
  }

 private:
  Status Place(std::uint32_t number) {
    const NetElement& drawn = drawn_[number];
    if (islands_.LayerCount() < 32 && (drawn.layers >> islands_.LayerCount()) != 0)
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{} is on a layer that does not exist: there are {}",
                              Describe(drawn.element), islands_.LayerCount()));
    extents_.push_back(INTAGLIO_TRY(ExtentOf(drawn)));
    conductor_.push_back(kNoIsland);
    for (std::uint32_t layer = 0; layer < islands_.LayerCount(); ++layer) {
      if ((drawn.layers >> layer & 1) == 0) continue;
      const std::uint32_t island = IslandOf(layer, extents_.back());
      if (island == kNoIsland) {
        if (drawn.terminal) AddLost(number);
        continue;
      }
      if (conductor_.back() != kNoIsland && drawn.terminal)
        islands_.Connect(conductor_.back(), island);
      conductor_.back() = island;
    }
    return {};
  }

  std::uint32_t IslandOf(std::uint32_t layer, const Extent& extent) const {
    for (const Vec2& place : extent.places) {
      const std::uint32_t island = islands_.At(layer, place);
      if (island != kNoIsland) return island;
    }
    return kNoIsland;
  }

  void AddLost(std::uint32_t number) {
    const Vec2& at = extents_[number].places.front();
    report_.faults.push_back(
        {FaultKind::kLost,
         drawn_[number].net,
         {},
         at,
         fmt::format("{} of net {} has no copper at ({:.4g}, {:.4g})",
                     NameOf(drawn_[number]), drawn_[number].net, at.x(), at.y())});
  }

  void CountIslands() {
    report_.island_count = islands_.Count();
    std::set<std::uint32_t> used;
    for (std::uint32_t k = 0; k < drawn_.size(); ++k) {
      if (drawn_[k].terminal && conductor_[k] != kNoIsland) used.insert(conductor_[k]);
    }
    report_.net_count = static_cast<std::uint32_t>(used.size());
    for (std::uint32_t island = 0; island < islands_.Count(); ++island) {
      if (!used.contains(islands_.Conductor(island))) ++report_.idle_count;
    }
  }

  using Members = std::vector<std::uint32_t>;

  /// The narrowest place between elements of both lists. Quadratic, of faulty nets alone.
  EdgeGap NarrowestPlace(const Members& a, const Members& b) const {
    EdgeGap narrowest{1e300, Vec2::Zero(), Vec2::Zero()};
    for (const std::uint32_t first : a) {
      for (const std::uint32_t second : b) {
        if (first == second || (drawn_[first].layers & drawn_[second].layers) == 0)
          continue;
        const EdgeGap gap = Nearest(extents_[first], extents_[second]);
        if (gap.distance_mm < narrowest.distance_mm) narrowest = gap;
      }
    }
    return narrowest;
  }

  void FindShorts() {
    std::map<std::uint32_t, std::map<std::string, Members>> nets_of;
    for (std::uint32_t k = 0; k < drawn_.size(); ++k) {
      if (conductor_[k] != kNoIsland && !drawn_[k].net.empty())
        nets_of[conductor_[k]][drawn_[k].net].push_back(k);
    }
    std::set<std::pair<std::string, std::string>> seen;
    for (const auto& [conductor, nets] : nets_of) {
      for (auto a = nets.begin(); a != nets.end(); ++a) {
        // Each net against that nearest to it: n nets in one are n - 1 shorts at least.
        std::optional<NetFault> fault;
        double width = 1e300;
        for (auto b = nets.begin(); b != a; ++b) {
          const EdgeGap gap = NarrowestPlace(a->second, b->second);
          if (fault && gap.distance_mm >= width) continue;
          width = gap.distance_mm;
          const Vec2 at = 0.5 * (gap.on_first_mm + gap.on_second_mm);
          fault =
              NetFault{FaultKind::kShort, b->first, a->first, at,
                       fmt::format("nets {} and {} are connected near ({:.4g}, {:.4g})",
                                   b->first, a->first, at.x(), at.y())};
        }
        if (fault && seen.insert({fault->net, fault->other_net}).second)
          report_.faults.push_back(std::move(*fault));
      }
    }
  }

  void FindOpens() {
    std::map<std::string, std::map<std::uint32_t, Members>> parts_of;
    for (std::uint32_t k = 0; k < drawn_.size(); ++k) {
      if (conductor_[k] != kNoIsland && !drawn_[k].net.empty())
        parts_of[drawn_[k].net][conductor_[k]].push_back(k);
    }
    for (auto& [net, parts] : parts_of) {
      // Tracks that lost their ends are no fault: they connect nothing.
      std::erase_if(parts, [&](const auto& part) {
        return std::none_of(part.second.begin(), part.second.end(),
                            [&](std::uint32_t k) { return drawn_[k].terminal; });
      });
      for (auto a = parts.begin(); a != parts.end(); ++a) {
        EdgeGap narrowest{1e300, Vec2::Zero(), Vec2::Zero()};
        for (auto b = parts.begin(); b != a; ++b) {
          const EdgeGap gap = NarrowestPlace(a->second, b->second);
          if (gap.distance_mm < narrowest.distance_mm) narrowest = gap;
        }
        if (a == parts.begin()) continue;
        const Vec2 at = 0.5 * (narrowest.on_first_mm + narrowest.on_second_mm);
        report_.faults.push_back(
            {FaultKind::kOpen,
             net,
             {},
             at,
             fmt::format(
                 "net {} is open near ({:.4g}, {:.4g}): {} is apart from the rest", net,
                 at.x(), at.y(), NameOf(TerminalOf(a->second)))});
      }
    }
  }

  const NetElement& TerminalOf(const Members& members) const {
    return drawn_[*std::find_if(members.begin(), members.end(),
                                [&](std::uint32_t k) { return drawn_[k].terminal; })];
  }

  Islands islands_;
  std::span<const NetElement> drawn_;
  std::vector<Extent> extents_;
  std::vector<std::uint32_t> conductor_;
  NetReport report_;
};

}  // namespace

Result<Region> CopperLeft(const Region& sheet, const Isolation& isolation,
                          double tool_diameter_mm) {
  std::vector<Edges> paths;
  for (const IsolationPass& pass : isolation.passes) {
    for (const Contour& contour : pass.contours) paths.push_back(contour.edges);
  }
  if (paths.empty()) return sheet;
  return Difference(sheet, INTAGLIO_TRY(Swept(paths, tool_diameter_mm)));
}

Result<NetReport> CompareNets(std::span<const Region> copper,
                              std::span<const NetElement> drawn) {
  return Comparison(copper, drawn).Run();
}

}  // namespace intaglio::contour
