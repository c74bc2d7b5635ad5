#pragma once

// Tabs on a closed path: where they are, and the path divided there.

#include <vector>

#include "engrave/contour/milling/cut.h"

namespace intaglio::contour {

struct TabPlaces {
  std::vector<double> ways_mm;  ///< of their middles from the path's begin, ascending
  int max_count = 0;            ///< that fit, when `ways_mm` has fewer than asked for
};

/// `length_mm` is what the tool's centre runs for a tab. Tab k of n belongs at
/// (k + 1/2) / n of the path; each is on a straight edge, wholly, apart from the others,
/// and as near to there as this leaves place for those behind it.
TabPlaces PlaceTabs(const Edges& path, int count, double length_mm);

/// `ways_mm` as of PlaceTabs.
std::vector<CutPiece> DividedAtTabs(const Edges& path, const std::vector<double>& ways_mm,
                                    double length_mm);

}  // namespace intaglio::contour
