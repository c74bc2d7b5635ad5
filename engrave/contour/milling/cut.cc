#include "engrave/contour/milling/cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "engrave/contour/contour_order.h"
#include "engrave/contour/crossings.h"
#include "engrave/contour/milling/cut_tabs.h"
#include "engrave/contour/option_range.h"
#include "engrave/contour/simple_loops.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// A lead touches the path at the entry; what lies nearer to it is that contact.
constexpr double kEntry_mm = 1e-2;
constexpr std::size_t kMaxEntries = 400;

Status CheckCutOptions(const CutOptions& options) {
  INTAGLIO_TRY(CheckOption("the tool's diameter", options.tool_diameter_mm, 0.001, 100));
  INTAGLIO_TRY(CheckOption("the lead", options.lead_mm, 0.01, 1000));
  INTAGLIO_TRY(CheckOption("the number of tabs", options.tabs.count, 0, 1000));
  INTAGLIO_TRY(CheckOption("the distance of tabs", options.tabs.distance_mm.value_or(1),
                           0.1, 10'000));
  INTAGLIO_TRY(CheckOption("the width of tabs", options.tabs.width_mm, 0.01, 1000));
  return CheckOption("the height of tabs", options.tabs.height_mm, 0.01, 1000);
}

std::string AtPlace(const Vec2& place) {
  return fmt::format("({:.4g}, {:.4g})", place.x(), place.y());
}

tl::unexpected<Error> Refused(const Vec2& place, const std::string& sentence) {
  return Fail(ErrorCode::kUnsupported, sentence,
              fmt::format("{:.6g}, {:.6g}", place.x(), place.y()));
}

/// The loop of the area nearest to a place.
std::uint32_t NearestLoop(const Region& area, const Vec2& place) {
  std::uint32_t nearest = 0;
  double distance = 1e300;
  for (std::uint32_t k = 0; k < area.loops.size(); ++k) {
    for (const Edge& edge : area.loops[k]) {
      const double to_edge = DistanceTo(edge, place);
      if (to_edge >= distance) continue;
      distance = to_edge;
      nearest = k;
    }
  }
  return nearest;
}

/// Each loop of the area has to have a path, which follows no other loop.
Result<std::vector<std::uint32_t>> PathsOfLoops(const Region& area, const Region& paths,
                                                double tool_mm) {
  std::vector<std::uint32_t> path_of(area.loops.size(), UINT32_MAX);
  for (std::uint32_t p = 0; p < paths.loops.size(); ++p) {
    const Edges& path = paths.loops[p];
    std::optional<std::uint32_t> loop;
    for (const Edge& edge : path) {
      const Vec2 place = PointAt(edge, edge.length_mm / 2);
      const std::uint32_t nearest = NearestLoop(area, place);
      if (loop && *loop != nearest)
        return Refused(place,
                       fmt::format("two contours near {} are nearer to each other than "
                                   "the tool of {:.4g} mm is wide; use a thinner one or "
                                   "move them apart",
                                   AtPlace(place), tool_mm));
      loop = nearest;
    }
    const Vec2& begin = path.front().begin_mm;
    if (path_of[*loop] != UINT32_MAX)
      return Refused(
          begin, fmt::format("the tool of {:.4g} mm does not pass the neck that leads to "
                             "{}; use a thinner one",
                             tool_mm, AtPlace(begin)));
    path_of[*loop] = p;
  }
  for (std::uint32_t k = 0; k < area.loops.size(); ++k) {
    if (path_of[k] != UINT32_MAX) continue;
    const Vec2& begin = area.loops[k].front().begin_mm;
    return Refused(begin, fmt::format("the tool of {:.4g} mm does not fit into the "
                                      "contour at {}; use a thinner one",
                                      tool_mm, AtPlace(begin)));
  }
  return path_of;
}

Edges TurnedRound(const Edges& loop) {
  Edges turned;
  for (auto edge = loop.rbegin(); edge != loop.rend(); ++edge)
    turned.push_back(Reversed(*edge));
  return turned;
}

/// The number of other loops around a loop.
int NestingOf(const Region& area, std::uint32_t loop) {
  int nesting = 0;
  for (std::uint32_t k = 0; k < area.loops.size(); ++k) {
    if (k != loop && IsInLoops(area.loops[k], area.loops[loop].front().begin_mm))
      ++nesting;
  }
  return nesting;
}

struct Leads {
  Edge in;
  Edge out;
};

/// `waste`: of length 1, from the path to the side that is not kept.
Leads MakeLeads(const Vec2& entry, const Vec2& along, const Vec2& waste, LeadKind kind,
                double size) {
  if (kind == LeadKind::kLine) {
    const double part = size / std::numbers::sqrt2;
    return {MakeLine(entry + part * (waste - along), entry),
            MakeLine(entry, entry + part * (waste + along))};
  }
  const Vec2 center = entry + size * waste;
  const bool left = Cross(along, waste) > 0;
  return {MakeArcBetween(center - size * along, entry, center, left),
          MakeArcBetween(entry, center + size * along, center, left)};
}

class Cutter {
 public:
  Cutter(const Region& area, const Region& paths, const CutOptions& options)
      : area_(area), paths_(paths), options_(options) {
    is_climb_ = options.direction == CutDirection::kClimb;
  }

  Result<Cut> CutAlong(std::uint32_t loop, std::uint32_t path) const {
    Cut cut;
    cut.loop = loop;
    // The area is to the left of its loops, so a loop around nothing runs clockwise.
    cut.inner = (AreaOf(area_.loops[loop]) < 0) == (options_.side == CutSide::kOutside);
    // Paths have the grown part, or the shrunk opening, to their left.
    const bool stays_left = options_.side == CutSide::kOutside;
    Edges edges = paths_.loops[path];
    if (stays_left == is_climb_) edges = TurnedRound(edges);
    if (options_.lead != LeadKind::kNone) {
      edges = INTAGLIO_TRY(WithLeads(edges, cut));
    }
    return WithTabs(edges, std::move(cut));
  }

 private:
  /// The middles of straight pieces, the longest first, then those of arcs, then places
  /// between.
  static std::vector<ContourVisit> Entries(const Edges& path) {
    std::vector<std::uint32_t> order(path.size());
    for (std::uint32_t k = 0; k < path.size(); ++k) order[k] = k;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (path[a].is_arc() != path[b].is_arc()) return path[b].is_arc();
      return path[a].length_mm > path[b].length_mm;
    });
    std::vector<ContourVisit> entries;
    for (const double part : {0.5, 0.25, 0.75, 0.1, 0.9}) {
      for (const std::uint32_t k : order) {
        if (entries.size() < kMaxEntries)
          entries.push_back({0, k, part * path[k].length_mm});
      }
    }
    return entries;
  }

  Result<Edges> WithLeads(const Edges& path, Cut& cut) const {
    for (const ContourVisit& entry : Entries(path)) {
      const Vec2 place = PointAt(path[entry.edge], entry.way_mm);
      const Vec2 along = DirectionAt(path[entry.edge], entry.way_mm);
      const Vec2 waste = is_climb_ ? Vec2(-RightOf(along)) : RightOf(along);
      const Leads leads = MakeLeads(place, along, waste, options_.lead, options_.lead_mm);
      if (!IsFree(leads.in, leads.in.begin_mm, place) ||
          !IsFree(leads.out, leads.out.end_mm, place))
        continue;
      cut.lead_in = {leads.in};
      cut.lead_out = {leads.out};
      return EdgesFrom(path, entry);
    }
    const Vec2& begin = path.front().begin_mm;
    return Refused(begin, fmt::format("a lead of {:.4g} mm would cut what stays, at all "
                                      "places of the contour at {}; use a shorter one",
                                      options_.lead_mm, AtPlace(begin)));
  }

  /// The tool's centre may be where the paths allow: not among the grown parts, or among
  /// the shrunk openings.
  bool IsFree(const Edge& lead, const Vec2& far_end, const Vec2& entry) const {
    if (IsInside(paths_, far_end) != (options_.side == CutSide::kInside)) return false;
    std::vector<Vec2> points;
    for (const Edges& path : paths_.loops) {
      for (const Edge& edge : path) AppendCrossings(lead, edge, points);
    }
    return std::all_of(points.begin(), points.end(), [&](const Vec2& point) {
      return (point - entry).norm() < std::min(kEntry_mm, options_.lead_mm / 2);
    });
  }

  Result<Cut> WithTabs(const Edges& path, Cut cut) const {
    const bool hole = options_.side == CutSide::kOutside && cut.inner;
    TabOptions tabs = options_.tabs;
    if (hole && !tabs.of_holes) tabs = {};
    cut.pieces = INTAGLIO_TRY(PiecesWithTabs(path, tabs, options_.tool_diameter_mm));
    for (const CutPiece& piece : cut.pieces) {
      if (piece.tab) cut.tabs_mm.push_back(PointAt(piece.edge, piece.edge.length_mm / 2));
    }
    return cut;
  }

  const Region& area_;
  const Region& paths_;
  const CutOptions& options_;
  bool is_climb_;
};

}  // namespace

Result<std::vector<Cut>> CutOut(const Region& area, const CutOptions& options) {
  INTAGLIO_TRY(CheckCutOptions(options));
  const double radius = options.tool_diameter_mm / 2;
  const Region paths = INTAGLIO_TRY(
      options.side == CutSide::kOutside ? Outset(area, radius) : Inset(area, radius));
  const std::vector<std::uint32_t> path_of =
      INTAGLIO_TRY(PathsOfLoops(area, paths, options.tool_diameter_mm));
  std::vector<std::pair<int, std::uint32_t>> order;  // the innermost first
  for (std::uint32_t k = 0; k < area.loops.size(); ++k)
    order.emplace_back(-NestingOf(area, k), k);
  std::sort(order.begin(), order.end());
  const Cutter cutter(area, paths, options);
  std::vector<Cut> cuts;
  for (const auto& [nesting, loop] : order)
    cuts.push_back(INTAGLIO_TRY(cutter.CutAlong(loop, path_of[loop])));
  return cuts;
}

Edges PathOf(const Cut& cut) {
  Edges path = cut.lead_in;
  for (const CutPiece& piece : cut.pieces) path.push_back(piece.edge);
  path.insert(path.end(), cut.lead_out.begin(), cut.lead_out.end());
  return path;
}

}  // namespace intaglio::contour
