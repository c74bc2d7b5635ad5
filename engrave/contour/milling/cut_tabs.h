#pragma once

// Tabs on a path: where they are, and the path divided there. Frame: drawing, mm.
//
// A tab lies wholly on one edge. On a line its way is the width of the material that is
// left and the diameter of the tool. On an arc of radius R the two ends of the way are as
// far apart in a straight line, d, so that the way is 2 R asin(d / 2 R): between the
// discs that the tool leaves at both ends the material has its width.

#include <vector>

#include "engrave/contour/milling/cut.h"

namespace intaglio::contour {

struct TabPlace {
  double way_mm = 0;     ///< of its middle from the path's begin
  double length_mm = 0;  ///< along the path
};

struct TabPlaces {
  std::vector<TabPlace> tabs;  ///< by growing way
  int max_count = 0;           ///< that fit, when `tabs` has fewer than asked for
};

/// `ends_apart_mm`: the straight distance of the ends of a tab, d. Tab k of n belongs at
/// (k + 1/2) / n of the path; each is on a line, wholly, apart from the others, and as
/// near to there as this leaves place for those behind it. Where the lines do not hold
/// them, arcs with a radius of d or more hold tabs as well.
TabPlaces PlaceTabs(const Edges& path, int count, double ends_apart_mm);

/// `tabs` as of PlaceTabs.
std::vector<CutPiece> DividedAtTabs(const Edges& path, const std::vector<TabPlace>& tabs);

/// The path with the number of tabs that `options` ask for, of_holes aside.
/// kUnsupported, with the place of the path's begin, when the path does not hold them.
Result<std::vector<CutPiece>> PiecesWithTabs(const Edges& path, const TabOptions& options,
                                             double tool_diameter_mm);

}  // namespace intaglio::contour
