#pragma once

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/galvo/mark_ticks.h"

namespace intaglio::cli {

/// The contours of a drawing (.dxf, .svg, .hpgl, .plt) as strokes, its middle at the
/// origin, mm; open curves that meet are joined. Prints the warnings of the reader.
Result<std::vector<galvo::MarkStroke>> ReadMarkStrokes(const std::string& file,
                                                       double size_limits);

/// Lowest and highest coordinates of a stroke.
Box3 ExtentOfStroke(const galvo::MarkStroke& stroke);

double LengthOfStroke(const galvo::MarkStroke& stroke);

/// Its places, of a closed one with the first again.
std::vector<Vec2> OutlineOf(const galvo::MarkStroke& stroke);

}  // namespace intaglio::cli
