#include "engrave/contour/mirror.h"

#include <numbers>
#include <variant>

namespace intaglio::contour {
namespace {

struct Mirror {
  double line_x_mm;

  Shape operator()(Circle s) const {
    s.center_mm = Mirrored(s.center_mm, line_x_mm);
    return s;
  }
  Shape operator()(Square s) const {
    s.center_mm = Mirrored(s.center_mm, line_x_mm);
    return s;
  }
  Shape operator()(Octagon s) const {
    s.center_mm = Mirrored(s.center_mm, line_x_mm);
    return s;
  }
  Shape operator()(Track s) const {
    s.begin_mm = Mirrored(s.begin_mm, line_x_mm);
    s.end_mm = Mirrored(s.end_mm, line_x_mm);
    return s;
  }
  Shape operator()(ArcTrack s) const {
    s.arc = Mirrored(s.arc, line_x_mm);
    return s;
  }
  Shape operator()(Outline s) const {
    for (Edges& loop : s.loops) {
      for (Edge& edge : loop) edge = Mirrored(edge, line_x_mm);
    }
    return s;
  }
};

}  // namespace

Vec2 Mirrored(const Vec2& place_mm, double line_x_mm) {
  return {2 * line_x_mm - place_mm.x(), place_mm.y()};
}

Edge Mirrored(const Edge& edge, double line_x_mm) {
  Edge mirrored = edge;
  mirrored.begin_mm = Mirrored(edge.begin_mm, line_x_mm);
  mirrored.end_mm = Mirrored(edge.end_mm, line_x_mm);
  if (!edge.is_arc()) return mirrored;
  mirrored.center_mm = Mirrored(edge.center_mm, line_x_mm);
  mirrored.begin_rad = std::numbers::pi - edge.begin_rad;
  mirrored.sweep_rad = -edge.sweep_rad;
  return mirrored;
}

Shape Mirrored(const Shape& shape, double line_x_mm) {
  return std::visit(Mirror{line_x_mm}, shape);
}

}  // namespace intaglio::contour
