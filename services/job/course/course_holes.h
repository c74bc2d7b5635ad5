#pragma once

// Holes and slots of drill files and boards against the copper that they belong to, and
// against each other. Frame: that of the files, mm.

#include <string>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"

namespace intaglio {

struct DrilledFile {
  std::string name;  ///< for messages
  std::vector<contour::Hole> holes;
  std::vector<contour::Element> slots;  ///< tracks and arc tracks, as in the file
  /// Drills and pads are in one file: what has no copper (np_thru_hole) is meant so.
  bool has_own_pads = false;
};

/// The middle of a slot; of equal ends of no length.
contour::Edge MiddleOfSlot(const contour::Element& slot);
double WidthOfSlot_mm(const contour::Element& slot);

/// A warning for each file with holes or slots that touch no copper, where there is
/// copper and the file has no pads of its own: a unit or digits that are wrong by powers
/// of ten put them there; and for each with some over each other. Slots that begin where
/// the one before ends and are as wide are one route, which may meet itself. With their
/// number, the first place, and what both reach over. Errors as of Rounded.
Result<Warnings> WarningsOfHoles(const std::vector<DrilledFile>& files,
                                 const std::vector<contour::Element>& copper);

}  // namespace intaglio
