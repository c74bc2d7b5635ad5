#pragma once

// Pads and graphics of KiCad boards as shapes. All errors are sentences without a place.

#include <optional>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/contour/files/s_expression.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// Where a footprint or a pad is: first turned, then moved. y points up.
struct KicadPlace {
  Vec2 at_mm = Vec2::Zero();
  double turned_rad = 0;  ///< counter-clockwise

  /// `file_mm`: with y down, as in the file.
  Vec2 Of(const Vec2& file_mm) const;
};

/// The numbers of the list `name` in an expression: (at X Y [DEGREES]). Fails with
/// kInvalidValue where it is missing or no number, or beyond 10 m.
Result<Vec2> KicadPoint(const SExpression& in, std::string_view name);
Result<KicadPlace> KicadAt(const SExpression& in);
/// The first number of the list `name`; `otherwise` where there is no such list.
Result<double> KicadNumber(const SExpression& in, std::string_view name,
                           double otherwise);

/// (pts (xy X Y) ..): corners of a polygon, at least three.
Result<std::vector<Vec2>> KicadCorners(const SExpression& in, const KicadPlace& place);

/// Through three points; a line where they are on one.
Edge KicadArc(const Vec2& begin_mm, const Vec2& middle_mm, const Vec2& end_mm);

/// The middle line of a graphic item: line, arc, circle, rect or poly, whatever it begins
/// with (gr_, fp_). Nothing for others.
struct KicadGraphic {
  Edges edges;
  bool closed = false;
  bool filled = false;
  double width_mm = 0;
};
Result<std::optional<KicadGraphic>> GraphicOf(const SExpression& item,
                                              const KicadPlace& place);

/// Its copper: the inside when filled, and the line where it has a width.
std::vector<Shape> ShapesOf(const KicadGraphic& graphic);

/// The copper of a pad. `pad_place`: its own, with the footprint's. Appends names of what
/// is not read to `left_out`.
Result<std::vector<Shape>> PadShapes(const SExpression& pad, const KicadPlace& pad_place,
                                     std::vector<std::string>& left_out);

}  // namespace intaglio::contour
