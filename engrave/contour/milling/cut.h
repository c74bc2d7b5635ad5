#pragma once

// Cutting parts out of a sheet, or openings into it: the tool runs beside the contour,
// half its diameter (of a laser half the kerf) away, begins and ends in the waste, and
// leaves tabs that hold the part. Frame: drawing, mm.

#include <cstdint>
#include <optional>
#include <vector>

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

enum class CutSide {
  kOutside,  ///< the area is the part: around its outer loops, inside its holes
  kInside,   ///< the area is taken out: inside its outer loops, around its islands
};

enum class CutDirection {
  kClimb,  ///< what stays to the right of the way, as for spindles that run clockwise
  kConventional,  ///< to the left
};

enum class LeadKind {
  kNone,
  kLine,  ///< straight, 45 degrees to the path
  kArc,   ///< a quarter of a circle, tangent to the path
};

struct TabOptions {
  int count = 0;  ///< of each contour, 0 .. 1000
  /// In place of the number: along the path at most, 0.1 .. 10 000.
  std::optional<double> distance_mm = {};
  double width_mm = 3;    ///< of the material that is left, 0.01 .. 1000
  double height_mm = 1;   ///< 0.01 .. 1000; above the sheet's bottom
  bool of_holes = false;  ///< in the holes of parts as well, whose waste then stays
};

struct CutOptions {
  double tool_diameter_mm = 1;  ///< 0.001 .. 100; of a laser the kerf
  CutSide side = CutSide::kOutside;
  CutDirection direction = CutDirection::kClimb;
  LeadKind lead = LeadKind::kNone;
  double lead_mm = 1;  ///< length of the line, radius of the arc; 0.01 .. 1000
  TabOptions tabs = {};
};

/// A piece of the closed path between its entry and its tabs.
struct CutPiece {
  Edge edge;
  bool tab = false;  ///< run above height_mm, or with the beam off
};

struct Cut {
  std::vector<CutPiece> pieces;  ///< closed: ends where it began
  Edges lead_in;                 ///< ends at the entry
  Edges lead_out;                ///< begins at the entry
  bool inner = false;            ///< inside the contour that it follows
  std::uint32_t loop = 0;        ///< of the region, that it follows
  std::vector<Vec2> tabs_mm;     ///< the middles of the tabs on the path
};

/// One cut a loop, inner ones before outer ones, so that parts do not come loose before
/// their holes are made. Tabs are on straight pieces, and on wide arcs where those do not
/// hold them (cut_tabs.h), as evenly along the path as these allow. Errors: kInvalidValue
/// for an option outside its range; kUnsupported, with the place, when the tool does not
/// fit into a contour, when two contours are nearer to each other than the tool is wide,
/// when no place of a contour lets a lead in without cutting what stays, or when the
/// pieces of a contour do not hold its tabs.
Result<std::vector<Cut>> CutOut(const Region& area, const CutOptions& options);

/// All of a cut in the order of the way.
Edges PathOf(const Cut& cut);

}  // namespace intaglio::contour
