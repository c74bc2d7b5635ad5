#pragma once

// Apertures of Gerber files: shapes about the origin, in mm.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct GerberAperture {
  std::vector<Shape> shapes;  ///< of a flash, centre at the origin
  double draw_width_mm = -1;  ///< of a circle without a hole; < 0: none
  Vec2 draw_box_mm{-1, -1};   ///< sides of a rectangle without a hole; < 0: none
};

/// Standard apertures: kind C, R, O or P with its numbers in file units. Errors are
/// sentences without a place.
Result<GerberAperture> StandardAperture(char kind, const std::vector<double>& numbers,
                                        double unit_mm);

/// A macro: its blocks between '*', without the name.
using GerberMacro = std::vector<std::string>;

/// The macro with these values of $1, $2 ...
Result<GerberAperture> MacroAperture(const GerberMacro& macro,
                                     const std::vector<double>& values, double unit_mm);

/// The same shape elsewhere.
Shape Moved(const Shape& shape, const Vec2& by_mm);

/// What a rectangle covers on its way, a convex polygon.
Outline SweptBox(const Vec2& sides_mm, const Vec2& from_mm, const Vec2& to_mm);

}  // namespace intaglio::contour
