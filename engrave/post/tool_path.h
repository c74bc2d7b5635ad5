#pragma once

// Contours as a controller makes them: an approach, then lines and arcs from the end of
// one to that of the next. Frame: drawing, mm, x to the right, y up.

#include <optional>
#include <string>
#include <vector>

#include "engrave/contour/edge.h"

namespace intaglio::post {

enum class WorkKind { kLine, kClockwise, kCounterClockwise };

/// A move at work. The fields of an arc are what controllers ask for (Siwiec 2016,
/// figures 4.10 - 4.12): any of them alone determines it, given its begin and end.
struct WorkMove {
  WorkKind kind = WorkKind::kLine;
  Vec2 end_mm = Vec2::Zero();
  Vec2 middle_mm = Vec2::Zero();             ///< of the arc, half way along it
  Vec2 center_from_begin_mm = Vec2::Zero();  ///< centre minus begin
  double radius_mm = 0;
  double sweep_rad = 0;  ///< 0..2 pi, whatever the direction
  bool tab = false;      ///< over a tab, which stays (tab_parts.h)
  /// At most, in place of the speed of the whole work, mm/s.
  std::optional<double> speed_mm_s = {};
};

/// What a move has besides its way: a tab and a speed of its own.
inline void KeepTabAndSpeed(const WorkMove& of, WorkMove& move) {
  move.tab = of.tab;
  move.speed_mm_s = of.speed_mm_s;
}

inline WorkMove LineTo(const Vec2& end_mm) {
  WorkMove move;
  move.end_mm = end_mm;
  return move;
}

struct ToolPath {
  std::string name;  ///< for messages, e.g. "contour 3"
  Vec2 begin_mm = Vec2::Zero();
  std::vector<WorkMove> moves;
};

/// The path along edges, each of which begins where the one before ends. With a
/// chord_tolerance_mm above 0 arcs become chords between places of the arc, so that no
/// chord is farther than that from it. An arc over more than 359 degrees is divided into
/// two: a circle that ends where it begins has no middle that determines it.
/// tabs: of each edge whether it runs over a tab; empty for none.
ToolPath PathOf(const contour::Edges& edges, std::string name,
                double chord_tolerance_mm = 0, const std::vector<bool>& tabs = {});

/// As PathOf of edges with a tolerance above 0. Chords keep what their arc has besides.
ToolPath Chorded(const ToolPath& path, double chord_tolerance_mm);

/// The edges again, e.g. for a length, a picture or a proof.
contour::Edges EdgesOf(const ToolPath& path);

/// How fast a turning axis in the origin of `edge` has to turn where that is fastest, so
/// that the tool keeps the speed along it: with the place p and the direction t of unit
/// length it is speed |p x t| / |p|^2, rad/s (TRANSMIT: w = v / rho where the tool passes
/// the axis). Infinite on a path through the axis.
double AxisSpeed_rad_s(const contour::Edge& edge, double speed_mm_s);

}  // namespace intaglio::post
