#include "engrave/contour/simple_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "engrave/contour/crossings.h"
#include "engrave/contour/edge_tree.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kMinArea_mm2 = 1e-9;
constexpr double kShared_mm = 1e-7;
// Some seconds and 320 MB.
constexpr std::uint64_t kMaxPairs = 40'000'000;

/// The edges of all loops, each with the one behind it.
struct Ring {
  Edges edges;
  std::vector<std::uint32_t> next;
};

Ring AllEdges(const std::vector<Edges>& loops) {
  Ring ring;
  for (const Edges& loop : loops) {
    const auto first = static_cast<std::uint32_t>(ring.edges.size());
    for (const Edge& edge : loop) {
      ring.edges.push_back(edge);
      ring.next.push_back(static_cast<std::uint32_t>(ring.edges.size()));
    }
    if (!loop.empty()) ring.next.back() = first;
  }
  return ring;
}

bool IsEnd(const Edge& edge, const Vec2& place) {
  return (place - edge.begin_mm).norm() < kVertex_mm ||
         (place - edge.end_mm).norm() < kVertex_mm;
}

/// Loops that meet in a corner of both have an inside all the same.
bool AreCornersOfBoth(const Edge& a, const Edge& b, const Vec2& place) {
  return IsEnd(a, place) && IsEnd(b, place);
}

/// A loop that comes back to a corner is several: from each corner back to it.
std::vector<Edges> DividedAtCorners(const Edges& loop) {
  using Corner = std::pair<double, double>;
  const auto corner_of = [](const Vec2& place) { return Corner(place.x(), place.y()); };
  std::vector<Edges> loops;
  Edges open;
  std::map<Corner, std::size_t> begins;  // of the edges of `open`
  for (const Edge& edge : loop) {
    begins.emplace(corner_of(edge.begin_mm), open.size());
    open.push_back(edge);
    const auto back = begins.find(corner_of(edge.end_mm));
    if (back == begins.end()) continue;
    const std::size_t first = back->second;
    loops.emplace_back(open.begin() + static_cast<std::ptrdiff_t>(first), open.end());
    for (std::size_t k = first; k < open.size(); ++k)
      begins.erase(corner_of(open[k].begin_mm));
    open.resize(first);
  }
  // Ends that agree to 1 um only: as it is.
  if (!open.empty()) return {loop};
  return loops;
}

/// Where two edges of one outline touch although they should not.
std::optional<Vec2> Contact(const Ring& ring, const Pair& pair) {
  const Edge& a = ring.edges[pair.first];
  const Edge& b = ring.edges[pair.second];
  std::vector<SharedPart> shared;
  AppendSharedParts(a, b, kShared_mm, shared);
  if (!shared.empty()) return PointAt(a, 0.5 * (shared[0].begin_mm + shared[0].end_mm));
  std::vector<Vec2> points;
  AppendCrossings(a, b, points);
  for (const Vec2& p : points) {
    const auto is_joint = [&](const Vec2& end, const Vec2& begin) {
      return (p - end).norm() < 4 * kVertex_mm && (end - begin).norm() < kVertex_mm;
    };
    if (ring.next[pair.first] == pair.second && is_joint(a.end_mm, b.begin_mm)) continue;
    if (ring.next[pair.second] == pair.first && is_joint(b.end_mm, a.begin_mm)) continue;
    if (AreCornersOfBoth(a, b, p)) continue;
    return p;
  }
  return std::nullopt;
}

tl::unexpected<Error> Wrong(const std::string& what, const Vec2& at) {
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("{} at ({:.6g}, {:.6g}); draw it as loops apart from each other", what,
                  at.x(), at.y()),
      fmt::format("{:.6g}, {:.6g}", at.x(), at.y()));
}

}  // namespace

// The polygon of all chords, and the segments between chords and arcs.
int TurnsAround(const Edge& e, const Vec2& p) {
  const double side = Cross(e.end_mm - e.begin_mm, p - e.begin_mm);
  const bool up = e.end_mm.y() > e.begin_mm.y();
  const bool counts =
      (e.begin_mm.y() <= p.y()) != (e.end_mm.y() <= p.y()) && (side > 0) == up;
  const int of_polygon = counts ? (up ? 1 : -1) : 0;
  if (!e.is_arc()) return of_polygon;
  // The segment of an arc that turns left lies to the right of the chord. A point on
  // the chord is to the right of it, as for the polygon, which takes a point at the
  // height of a corner to be above it.
  const bool above = e.begin_mm.y() == e.end_mm.y() && e.end_mm.x() > e.begin_mm.x();
  const bool right = side < 0 || (side == 0 && !above);
  if (e.begin_mm != e.end_mm && right != (e.sweep_rad > 0)) return of_polygon;
  const bool in_segment = (p - e.center_mm).squaredNorm() < e.radius_mm * e.radius_mm;
  return of_polygon + (in_segment ? (e.sweep_rad > 0 ? 1 : -1) : 0);
}

bool IsInLoops(const Edges& edges, const Vec2& p) {
  bool inside = false;
  for (const Edge& edge : edges) inside ^= CountsInLoops(edge, p);
  return inside;
}

Result<std::vector<Edges>> OrientedLoops(const std::vector<Edges>& drawn) {
  std::vector<Edges> loops;
  for (const Edges& loop : drawn) {
    for (Edges& part : DividedAtCorners(loop)) loops.push_back(std::move(part));
  }
  const Ring ring = AllEdges(loops);
  if (ring.edges.empty()) return Fail(ErrorCode::kInvalidValue, "has no edges");
  std::vector<FlatBox> boxes;
  for (const Edge& edge : ring.edges) boxes.push_back(FlatBoxOf(edge));
  const auto pairs = INTAGLIO_TRY(NearPairsUpTo(boxes, kVertex_mm, kMaxPairs));
  for (const Pair& pair : pairs) {
    if (const auto place = Contact(ring, pair))
      return Wrong("crosses or touches itself", *place);
  }
  std::vector<Edges> oriented;
  for (const Edges& loop : loops) {
    if (loop.empty()) continue;
    const double area = AreaOf(loop);
    if (std::abs(area) < kMinArea_mm2)
      return Wrong("has a loop without an area", loop[0].begin_mm);
    bool is_hole = false;
    for (const Edges& other : loops) {
      if (&other != &loop && !other.empty() &&
          IsInLoops(other, PointAt(loop[0], loop[0].length_mm / 2)))
        is_hole = !is_hole;
    }
    oriented.push_back(loop);
    if ((area > 0) != is_hole) continue;
    Edges& turned = oriented.back();
    std::reverse(turned.begin(), turned.end());
    for (Edge& edge : turned) edge = Reversed(edge);
  }
  return oriented;
}

}  // namespace intaglio::contour
