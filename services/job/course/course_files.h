#pragma once

// The files of a course: circuit boards and drawings as elements, holes and curves.
// Frame: the files', mm, x to the right, y up.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/element.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/job/course/course_nets.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// A curve of a drawing that is followed, lines and arcs.
struct DrawnCurve {
  std::string name;  ///< "plate.dxf, curve 3"
  contour::Edges edges;
  bool closed = false;
  bool opening = false;  ///< of a slot: nothing is held by it, so it has no tabs
};

struct CourseFiles {
  std::vector<contour::Element> elements;
  std::vector<contour::Hole> holes;
  std::vector<DrawnCurve> curves;
  std::vector<DrawnNets> boards;  ///< those whose file has the nets; in `elements`, too
};

/// What is said of the files beside the course.
struct CourseFileOptions {
  std::string drill_units;     ///< the line of units that a drill file lacks
  std::optional<bool> mirror;  ///< turn all over; default: when a file draws the back
  /// About this line along y; default the middle of a board of KiCad, else 0.
  std::optional<double> mirror_x_mm;
  /// Holes for pins on this line, where the board lies the same on both of its sides: y
  /// of each, mm, beside the board; empty: none.
  std::vector<double> alignment_y_mm = {};
  double alignment_diameter_mm = 3;
  bool replace_drill_units = false;  ///< drill_units go before what drill files declare
};

/// Of `course.files`, whose contents are `texts`: drawings by their extension (.dxf,
/// .svg, .hpgl, .plt, .nci), projects by theirs (.xml), boards of KiCad by theirs
/// (.kicad_pcb; course.layer of them, of cuts their outline), Gerber and Excellon files
/// by what they hold. Drawings are curves for a course along curves, else outlines, of
/// exact lines and arcs both: a contour in an odd number of others is a hole of the
/// smallest of these. What is read and not made is added to `warnings`, also before an
/// error, and so are holes and slots beside all copper or over each other
/// (course_holes.h); slots are milled or drilled (course_slots.h). What draws the back of
/// a board is mirrored with all that is beside it (course_side.h). Errors as of the
/// readers; kUnreadable: none of these; kInvalidValue: a contour that is open, with its
/// place.
Result<CourseFiles> CourseFilesOf(const Course& course,
                                  const std::vector<std::string_view>& texts,
                                  const ReadLimits& limits, Warnings& warnings,
                                  const CourseFileOptions& options = {});

}  // namespace intaglio
