// The speed of a turning axis along an arc about c with radius r, u = (p - c) / r and
// s = c . u: p x t = +-(r + s), |p|^2 = |c|^2 + r^2 + 2 r s, so w / v is a function of s
// alone. Its derivative has the sign of (|c|^2 - r^2) throughout, but where r + s changes
// its sign and w is 0: its maximum is at an end of the range of s. Those are the ends of
// the arc, and the places nearest to and farthest from the axis.
#include "engrave/post/tool_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::post {
namespace {

constexpr double kNearlyCircleRad = 359 * std::numbers::pi / 180;
// Nearer to the axis no direction of the place is known.
constexpr double kOnAxisMm = 1e-9;

void AddEdge(const contour::Edge& edge, double tolerance_mm, ToolPath& path) {
  if (!edge.is_arc()) {
    path.moves.push_back(LineTo(edge.end_mm));
    return;
  }
  if (tolerance_mm > 0) {
    // Sagitta r (1 - cos(a / 2)) of a chord over the angle a; three chords or more, so
    // that a circle keeps an area.
    const double ratio = std::min(1.0, tolerance_mm / edge.radius_mm);
    const double angle = std::min(2 * std::acos(1 - ratio), 2 * std::numbers::pi / 3);
    const int count =
        std::max(1, static_cast<int>(std::ceil(std::abs(edge.sweep_rad) / angle)));
    for (int k = 1; k <= count; ++k) {
      const Vec2 end =
          k == count ? edge.end_mm : contour::PointAt(edge, edge.length_mm * k / count);
      path.moves.push_back(LineTo(end));
    }
    return;
  }
  const double half = edge.length_mm / 2;
  const Vec2 middle = contour::PointAt(edge, half);
  if (std::abs(edge.sweep_rad) > kNearlyCircleRad) {
    AddEdge(contour::PartOf(edge, 0, half, edge.begin_mm, middle), 0, path);
    AddEdge(contour::PartOf(edge, half, edge.length_mm, middle, edge.end_mm), 0, path);
    return;
  }
  path.moves.push_back(
      {edge.sweep_rad < 0 ? WorkKind::kClockwise : WorkKind::kCounterClockwise,
       edge.end_mm, middle, edge.center_mm - edge.begin_mm, edge.radius_mm,
       std::abs(edge.sweep_rad)});
}

contour::Edge EdgeOf(const WorkMove& move, const Vec2& begin_mm) {
  if (move.kind == WorkKind::kLine) return contour::MakeLine(begin_mm, move.end_mm);
  const contour::Edge arc =
      contour::MakeArcBetween(begin_mm, move.end_mm, begin_mm + move.center_from_begin_mm,
                              move.kind == WorkKind::kCounterClockwise);
  // Ends that agree to the rounding of doubles are a whole turn only if it is one.
  if (std::abs(std::abs(arc.sweep_rad) - move.sweep_rad) > 1)
    return contour::MakeLine(begin_mm, move.end_mm);
  return arc;
}

double AxisSpeedAt(const Vec2& place_mm, const Vec2& direction, double speed_mm_s) {
  const double across = std::abs(contour::Cross(place_mm, direction));
  const double square = place_mm.squaredNorm();
  if (square > kOnAxisMm * kOnAxisMm) return speed_mm_s * across / square;
  return std::numeric_limits<double>::infinity();
}

}  // namespace

ToolPath PathOf(const contour::Edges& edges, std::string name, double chord_tolerance_mm,
                const std::vector<bool>& tabs) {
  Require(tabs.empty() || tabs.size() == edges.size(), "{} edges have {} flags of tabs",
          edges.size(), tabs.size());
  ToolPath path{std::move(name), {}, {}};
  if (edges.empty()) return path;
  path.begin_mm = edges.front().begin_mm;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const std::size_t first = path.moves.size();
    AddEdge(edges[k], chord_tolerance_mm, path);
    if (tabs.empty() || !tabs[k]) continue;
    for (std::size_t i = first; i < path.moves.size(); ++i) path.moves[i].tab = true;
  }
  return path;
}

ToolPath Chorded(const ToolPath& path, double chord_tolerance_mm) {
  const contour::Edges edges = EdgesOf(path);
  ToolPath chorded{path.name, path.begin_mm, {}};
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const std::size_t first = chorded.moves.size();
    AddEdge(edges[k], chord_tolerance_mm, chorded);
    for (std::size_t i = first; i < chorded.moves.size(); ++i)
      KeepTabAndSpeed(path.moves[k], chorded.moves[i]);
  }
  return chorded;
}

contour::Edges EdgesOf(const ToolPath& path) {
  contour::Edges edges;
  Vec2 at_mm = path.begin_mm;
  for (const WorkMove& move : path.moves) {
    edges.push_back(EdgeOf(move, at_mm));
    at_mm = move.end_mm;
  }
  return edges;
}

double AxisSpeed_rad_s(const contour::Edge& edge, double speed_mm_s) {
  if (edge.length_mm <= 0) return 0;
  double worst = 0;
  const auto check = [&](double s_mm) {
    worst = std::max(worst, AxisSpeedAt(contour::PointAt(edge, s_mm),
                                        contour::DirectionAt(edge, s_mm), speed_mm_s));
  };
  check(0);
  check(edge.length_mm);
  // The places nearest to the axis and farthest from it, where they lie on the edge.
  const double near_mm = contour::WayTo(edge, Vec2::Zero());
  if (near_mm > 0 && near_mm < edge.length_mm) check(near_mm);
  if (edge.is_arc()) {
    const double far_mm = contour::WayTo(edge, 2 * edge.center_mm);
    if (far_mm > 0 && far_mm < edge.length_mm) check(far_mm);
  }
  return worst;
}

}  // namespace intaglio::post
