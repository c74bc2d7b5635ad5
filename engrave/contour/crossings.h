#pragma once

// Where two edges meet: single points, and the parts where one runs along the other.

#include <vector>

#include "engrave/contour/edge.h"

namespace intaglio::contour {

/// Two places nearer than this are one vertex, mm: 4 nm, above the rounding of
/// coordinates (1 nm) and far above that of doubles on a board of 10 m.
inline constexpr double kVertex_mm = 4e-6;

/// Appends the points that both edges reach, to kVertex_mm, ends included; points where
/// they touch as well. At most two, none where one runs along the other.
void AppendCrossings(const Edge& a, const Edge& b, std::vector<Vec2>& points_mm);

/// A part of an edge along which another runs.
struct SharedPart {
  double begin_mm = 0;  ///< way along the edge
  double end_mm = 0;
  bool same_direction = false;
};

/// Appends the parts of `a` along which `b` runs, nowhere farther from it than
/// tolerance_mm: at most two. AppendSharedParts(b, a) gives the same parts on `b`.
void AppendSharedParts(const Edge& a, const Edge& b, double tolerance_mm,
                       std::vector<SharedPart>& parts);

}  // namespace intaglio::contour
