#pragma once

// How much of a sheet parts use (Tirnovean 2016, ch. 5.6.3): g = AP / AS (5.4) of the
// sheet's area AS, with AP = P - G (5.5), the area P of the parts without that of their
// holes G. The published program has the contours clicked, arcs as many short lines; here
// they come from a drawing, exactly, or from a picture.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

struct MaterialUse {
  double sheet_mm2 = 0;  ///< AS
  double parts_mm2 = 0;  ///< P
  double holes_mm2 = 0;  ///< G
  double used_mm2 = 0;   ///< AP
  double use_percent = 0;
  std::uint32_t part_count = 0;
  std::uint32_t hole_count = 0;
};

/// Loops of any order and direction: one is the sheet, around all others; those in it are
/// parts, those in parts are holes, those in holes parts again. Errors: kInvalidValue
/// where loops cross or touch (with the place), or no loop or more than one is outermost.
Result<MaterialUse> MaterialUseOf(const std::vector<Edges>& loops);

/// Of a picture that is the sheet: brightness 0 (part) .. 65535 (waste), row by row. Grey
/// counts in part, as smooth borders have it: the share of the area is right to some
/// 0.01 % at one pixel a mm. pixels_per_mm > 0 gives mm2 alone: g does not depend on it.
/// P and G are not told apart. Fails with kInvalidValue for no pixel or scale.
Result<MaterialUse> MaterialUseOf(std::span<const std::uint16_t> brightness,
                                  double pixels_per_mm);

}  // namespace intaglio::contour
