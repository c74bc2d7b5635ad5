#pragma once

// Holes of drill files against the copper that they belong to. Frame: that of the files,
// mm.

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
};

/// A warning for each file with holes that touch no copper, where there is copper: a unit
/// or digits that are wrong by powers of ten put them there; and for each with holes over
/// each other. With their number, the first place, and what both reach over. Errors as of
/// Rounded.
Result<Warnings> WarningsOfHoles(const std::vector<DrilledFile>& files,
                                 const std::vector<contour::Element>& copper);

}  // namespace intaglio
