#pragma once

// Areas of a course: cleared as pockets, or cut out along their contours. Frame: that of
// the files, mm.

#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"
#include "proto/course.pb.h"

namespace intaglio {

struct AreaPaths {
  std::vector<contour::Edges> paths;    ///< in the order of milling, which is not changed
  std::vector<int> passes;              ///< of each path, from 0
  std::vector<std::vector<bool>> tabs;  ///< of cuts: of each edge whether a tab stays
  double left_mm2 = 0;                  ///< of pockets: corners and necks that stay
  double left_at_wall_mm = 0;           ///< of pockets: Pocket::tolerance_mm
};

/// With a step of the tool's diameter times 1 - overlap_ratio. The tool comes from
/// `start_mm`. Errors as of ClearPocket.
Result<AreaPaths> ClearAreas(const Course& course,
                             const std::vector<contour::Element>& areas,
                             const Vec2& start_mm);

/// Inner contours before outer ones, with an arc at the entry if course.lead_mm is given.
/// Errors as of CutOut.
Result<AreaPaths> CutAreas(const Course& course,
                           const std::vector<contour::Element>& areas);

}  // namespace intaglio
