#pragma once

// The files of a course: circuit boards and drawings as elements, holes and curves.
// Frame: the files', mm, x to the right, y up.

#include <string>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/cli/contour/contour_nets.h"

namespace intaglio::cli {

/// A curve of a drawing, as lines within 1 um of it.
struct DrawnCurve {
  std::string name;  ///< "plate.dxf, curve 3"
  contour::Edges edges;
  bool closed = false;
};

struct CourseFiles {
  std::vector<contour::Element> elements;
  std::vector<contour::Hole> holes;
  std::vector<DrawnCurve> curves;
  std::vector<DrawnNets> boards;  ///< those whose file has the nets; in `elements`, too
};

/// Of `course.files`: drawings by their extension (.dxf, .svg, .hpgl, .plt), projects by
/// theirs (.xml), boards of KiCad by theirs (.kicad_pcb; course.layer of them), Gerber
/// and Excellon files by what they hold. What is read and not made is added to
/// `warnings`. Errors as of the readers; kUnreadable: none of these.
Result<CourseFiles> ReadCourseFiles(const Course& course, double size_limits,
                                    Warnings& warnings);

/// Closed curves as outlines: one that lies in an odd number of others is a hole of the
/// smallest of these. kInvalidValue: an open curve, with its ends.
Result<std::vector<contour::Element>> OutlinesOf(const std::vector<DrawnCurve>& curves);

}  // namespace intaglio::cli
