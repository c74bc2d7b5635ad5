#pragma once

// Parts side by side on sheets: five ways are tried, and the one is kept that needs the
// fewest sheets, of several the one that uses the least height of the last sheet.
//
// Three ways go by the boxes around the parts: "bottom left" on a skyline (Jylanki, A
// thousand ways to pack the bin, 2010, ch. 2.4). Parts are taken by the longer side of
// their box, the longest first; each goes to the lowest place where it fits, of several
// the leftmost, upright or turned by 90 degrees; where no sheet has a place, a new one
// follows. Parts are turned where that is lower, upright first, or turned first. The
// others go by outlines (nest_outlines.h): parts that interlock lie in each other.
// Frame: sheet, mm, origin in its lower left corner.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

struct NestOptions {
  Vec2 sheet_mm{600, 400};
  double gap_mm = 2;     ///< between parts: at least the kerf; 0 .. 1000
  double margin_mm = 5;  ///< along the sheet's border, 0 .. 1000
  bool turn = true;      ///< by quarters where that is lower
};

struct NestedPart {
  std::uint32_t part = 0;   ///< number of the part
  std::uint32_t sheet = 0;  ///< from 0
  Vec2 moved_mm = Vec2::Zero();
  /// 0 .. 3 quarters about the origin, counter-clockwise, before it is moved.
  int quarter_turns = 0;
};

struct Nest {
  std::vector<NestedPart> parts;  ///< in the order of the parts
  std::uint32_t sheet_count = 0;
  double use_percent = 0;  ///< of the sheets, by the parts' areas
  double last_top_mm = 0;  ///< of the last sheet, up to which it is used
};

/// Errors are kInvalidValue: an option outside its range, a part without a loop, one that
/// does not fit into the sheet (with its size).
Result<Nest> NestParts(std::span<const Region> parts, const NestOptions& options);

/// A part at its place on its sheet.
Region Placed(const Region& part, const NestedPart& place);

}  // namespace intaglio::contour
