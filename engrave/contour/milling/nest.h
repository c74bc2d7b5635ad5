#pragma once

// Parts side by side on sheets, by the boxes around them: "bottom left" on a skyline
// (Jylanki, A thousand ways to pack the bin, 2010, ch. 2.4). Parts are taken by the
// longer side of their box, the longest first; each goes to the lowest place where it
// fits, of several the leftmost, upright or turned by 90 degrees; where no sheet has a
// place, a new one follows. This is done three times: with parts turned where that is
// lower, upright first, and turned first; the fewest sheets are kept. Outlines that
// interlock are not packed closer than their boxes. Frame: sheet, mm, origin in its lower
// left corner.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

struct NestOptions {
  Vec2 sheet_mm{600, 400};
  double gap_mm = 2;     ///< between parts: at least the kerf; 0 .. 1000
  double margin_mm = 5;  ///< along the sheet's border, 0 .. 1000
  bool turn = true;      ///< by 90 degrees where that is lower
};

struct NestedPart {
  std::uint32_t part = 0;   ///< number of the part
  std::uint32_t sheet = 0;  ///< from 0
  Vec2 moved_mm = Vec2::Zero();
  bool turned = false;  ///< about the origin, counter-clockwise, before it is moved
};

struct Nest {
  std::vector<NestedPart> parts;  ///< in the order of the parts
  std::uint32_t sheet_count = 0;
  double use_percent = 0;  ///< of the sheets, by the parts' areas
};

/// Errors are kInvalidValue: an option outside its range, a part without a loop, one that
/// does not fit into the sheet (with its size).
Result<Nest> NestParts(std::span<const Region> parts, const NestOptions& options);

/// A part at its place on its sheet.
Region Placed(const Region& part, const NestedPart& place);

}  // namespace intaglio::contour
