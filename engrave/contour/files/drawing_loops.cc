#include "engrave/contour/files/drawing_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/region/loose_edges.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/try.h"
#include "engrave/curve/open_ends.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
// An ellipse whose axes differ by less, relatively, is a circle.
constexpr double kCircle = 1e-9;
constexpr double kSameLoop_mm = 1e-3;
constexpr double kSamePlace_mm = 1e-6;

Vec2 Flat(const Vec3& p) { return {p.x(), p.y()}; }

/// The arc, where the piece is one of a circle in the plane of the drawing.
std::optional<Edge> CircularArc(const drawing::EllipticArc& arc) {
  const Vec2 u = Flat(arc.axis_u_mm);
  const Vec2 v = Flat(arc.axis_v_mm);
  const double r = u.norm();
  if (!(r > 0) || std::abs(v.norm() - r) > kCircle * r ||
      std::abs(u.dot(v)) > kCircle * r * r || std::abs(arc.sweep_rad) < 1e-9)
    return std::nullopt;
  const double side = Cross(u, v) > 0 ? 1 : -1;
  const double begin = std::atan2(u.y(), u.x()) + side * arc.begin_rad;
  return MakeArc(Flat(arc.center_mm), r, begin, side * arc.sweep_rad);
}

/// All edges of a curve, the lines between its pieces among them.
class CurveEdges {
 public:
  explicit CurveEdges(const LoopOptions& options) : options_(options) {}

  Status Append(const drawing::Curve& curve) {
    begin_.reset();
    for (const drawing::Piece& piece : curve.pieces) {
      if (const auto* line = std::get_if<drawing::Polyline>(&piece)) {
        for (const Vec3& p : line->points_mm) LineTo(Flat(p));
      } else if (const auto arc = ArcOf(piece)) {
        LineTo(arc->begin_mm);
        edges_.push_back(*arc);
        at_ = arc->end_mm;
      } else {
        INTAGLIO_TRY(AppendChords(piece));
      }
    }
    if (curve.closed && begin_) LineTo(*begin_);
    return {};
  }
  Edges Take() { return std::move(edges_); }

 private:
  static std::optional<Edge> ArcOf(const drawing::Piece& piece) {
    const auto* arc = std::get_if<drawing::EllipticArc>(&piece);
    return arc != nullptr ? CircularArc(*arc) : std::nullopt;
  }

  void LineTo(const Vec2& to) {
    if (!begin_)
      begin_ = to;
    else if (to != at_)
      edges_.push_back(MakeLine(at_, to));
    at_ = to;
  }

  Status AppendChords(const drawing::Piece& piece) {
    drawing::Drawing one;
    one.curves.push_back({{piece}});
    const auto flat = INTAGLIO_TRY(
        drawing::Flatten(one, {options_.chord_tolerance_mm, 1.0, 10'000'000}));
    for (const drawing::FlatCurve& curve : flat.curves) {
      for (const Vec3& p : curve.points_mm) LineTo(Flat(p));
      if (curve.closed && !curve.points_mm.empty()) LineTo(Flat(curve.points_mm[0]));
    }
    return {};
  }

  const LoopOptions& options_;
  std::optional<Vec2> begin_;
  Vec2 at_ = Vec2::Zero();
  Edges edges_;
};

Status CheckLoopOption(const char* name, double value, double min) {
  if (value >= min && value <= 1) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("{} is {} mm, it has to be {} .. 1; correct it", name, value, min),
      fmt::format("{}", value));
}

/// By area, length and the places of their corners.
bool AreSameLoop(const Edges& a, const Edges& b) {
  if (std::abs(std::abs(AreaOf(a)) - std::abs(AreaOf(b))) > kSameLoop_mm * LengthOf(a) ||
      std::abs(LengthOf(a) - LengthOf(b)) > kSameLoop_mm)
    return false;
  // Most loops of one size lie elsewhere, which one place shows.
  if (std::ranges::none_of(b, [&](const Edge& other) {
        return DistanceTo(other, a.front().begin_mm) < kSameLoop_mm;
      }))
    return false;
  const EdgeTree tree(b);
  return std::ranges::all_of(a, [&](const Edge& edge) {
    return tree.DistanceTo(edge.begin_mm) < kSameLoop_mm &&
           tree.DistanceTo(PointAt(edge, edge.length_mm / 2)) < kSameLoop_mm;
  });
}

std::vector<Edges> WithoutRepeated(std::vector<Edges> loops) {
  std::vector<Edges> kept;
  for (Edges& loop : loops) {
    bool seen = false;
    for (const Edges& other : kept) seen = seen || AreSameLoop(loop, other);
    if (!seen) kept.push_back(std::move(loop));
  }
  return kept;
}

/// A curve, or several that were joined.
struct Chain {
  Edges edges;
  std::uint32_t layer = 0;
  bool closed = false;

  Vec2 EndMm(int side) const {
    return side == 0 ? edges.front().begin_mm : edges.back().end_mm;
  }
};

/// Where chains begin and end, of those that may be joined.
std::vector<std::optional<curve::CurveEnds>> EndsOf(const std::vector<Chain>& chains) {
  std::vector<std::optional<curve::CurveEnds>> ends(chains.size());
  for (std::size_t i = 0; i < chains.size(); ++i) {
    if (chains[i].closed) continue;
    const Vec2 begin = chains[i].EndMm(0), end = chains[i].EndMm(1);
    ends[i] = curve::CurveEnds{
        chains[i].layer, {begin.x(), begin.y(), 0}, {end.x(), end.y(), 0}};
  }
  return ends;
}

Edges Backwards(const Edges& edges) {
  Edges turned;
  for (auto edge = edges.rbegin(); edge != edges.rend(); ++edge)
    turned.push_back(Reversed(*edge));
  return turned;
}

void LineToClose(const Vec2& to_mm, Edges& edges) {
  Edge& last = edges.back();
  if ((last.end_mm - to_mm).norm() < kSamePlace_mm)
    last.end_mm = to_mm;
  else
    edges.push_back(MakeLine(last.end_mm, to_mm));
}

/// From the chain of the end `first`, along the partners, until there is none or the
/// first is met again.
FollowedCurve JoinedFrom(curve::End first, const std::vector<Chain>& chains,
                         const curve::OpenEnds& ends, std::vector<char>& used) {
  FollowedCurve joined;
  curve::End entry = first;
  while (entry != curve::kNoEnd && used[entry / 2] == 0) {
    used[entry / 2] = 1;
    const Edges& next = chains[entry / 2].edges;
    const Edges part = entry % 2 == 0 ? next : Backwards(next);
    if (!joined.edges.empty()) LineToClose(part.front().begin_mm, joined.edges);
    joined.edges.insert(joined.edges.end(), part.begin(), part.end());
    entry = ends.PartnerOf(curve::OtherEnd(entry));
  }
  joined.closed = entry == first;
  if (joined.closed) LineToClose(joined.edges.front().begin_mm, joined.edges);
  return joined;
}

std::vector<FollowedCurve> JoinedChains(std::vector<Chain> chains, double joint_mm) {
  // Ends nearer than the joint, and not those as far apart as it.
  const curve::OpenEnds ends(EndsOf(chains), std::nextafter(joint_mm, 0));
  std::vector<char> used(chains.size(), 0);
  std::vector<std::pair<std::size_t, FollowedCurve>> joined;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    if (chains[i].closed) {
      used[i] = 1;
      joined.emplace_back(i, FollowedCurve{std::move(chains[i].edges), true});
    } else if (used[i] == 0) {
      // From a free end, so that the row is taken whole; of a ring from anywhere.
      joined.emplace_back(i, JoinedFrom(ends.FirstOfChain(2 * i), chains, ends, used));
    }
  }
  std::vector<FollowedCurve> curves;
  for (auto& [first, curve] : joined) curves.push_back(std::move(curve));
  return curves;
}

std::vector<FollowedCurve> WithoutRepeatedCurves(std::vector<FollowedCurve> curves) {
  std::vector<FollowedCurve> kept;
  std::multimap<double, std::size_t> by_left_mm;
  for (FollowedCurve& curve : curves) {
    const double left_mm = BoxOfEdges(curve.edges).min_mm.x();
    bool seen = false;
    const auto last = by_left_mm.upper_bound(left_mm + kSameLoop_mm);
    for (auto one = by_left_mm.lower_bound(left_mm - kSameLoop_mm);
         curve.closed && one != last && !seen; ++one)
      seen = AreSameLoop(curve.edges, kept[one->second].edges);
    if (seen) continue;
    if (curve.closed) by_left_mm.emplace(left_mm, kept.size());
    kept.push_back(std::move(curve));
  }
  return kept;
}

}  // namespace

Result<std::vector<FollowedCurve>> CurvesOfDrawing(const drawing::Drawing& drawing,
                                                   const LoopOptions& options) {
  INTAGLIO_TRY(CheckLoopOption("the chord tolerance", options.chord_tolerance_mm, 1e-6));
  INTAGLIO_TRY(CheckLoopOption("the joint", options.joint_mm, 1e-5));
  std::vector<Chain> chains;
  for (const drawing::Curve& curve : drawing.curves) {
    CurveEdges reader(options);
    INTAGLIO_TRY(reader.Append(curve));
    Chain chain{reader.Take(), curve.layer, false};
    if (chain.edges.empty() || LengthOf(chain.edges) == 0) continue;
    chain.closed = (chain.EndMm(0) - chain.EndMm(1)).norm() < kSamePlace_mm;
    chains.push_back(std::move(chain));
  }
  return WithoutRepeatedCurves(JoinedChains(std::move(chains), options.joint_mm));
}

Result<std::vector<Edges>> LoopsOfDrawing(const drawing::Drawing& drawing,
                                          const LoopOptions& options) {
  INTAGLIO_TRY(CheckLoopOption("the chord tolerance", options.chord_tolerance_mm, 1e-6));
  INTAGLIO_TRY(CheckLoopOption("the joint", options.joint_mm, 1e-5));
  CurveEdges edges(options);
  for (const drawing::Curve& curve : drawing.curves) INTAGLIO_TRY(edges.Append(curve));
  auto loops = INTAGLIO_TRY(JoinLoops(edges.Take(), options.joint_mm));
  if (loops.empty())
    return Fail(ErrorCode::kInvalidValue,
                "the drawing has no curve; draw a closed contour");
  return WithoutRepeated(std::move(loops));
}

}  // namespace intaglio::contour
