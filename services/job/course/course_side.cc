#include "services/job/course/course_side.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <utility>
#include <vector>

#include "engrave/contour/mirror.h"

namespace intaglio {
namespace {

void MirrorFiles(double line_x_mm, CourseFiles& files) {
  for (contour::Element& element : files.elements)
    element.shape = contour::Mirrored(element.shape, line_x_mm);
  for (contour::Hole& hole : files.holes)
    hole.center_mm = contour::Mirrored(hole.center_mm, line_x_mm);
  for (DrawnCurve& curve : files.curves) {
    for (contour::Edge& edge : curve.edges) edge = contour::Mirrored(edge, line_x_mm);
  }
  for (DrawnNets& board : files.boards) {
    for (contour::NetElement& drawn : board.elements)
      drawn.element.shape = contour::Mirrored(drawn.element.shape, line_x_mm);
  }
}

double LineOf(const CourseFileOptions& options, const CourseSide& side) {
  return options.mirror_x_mm.value_or(side.middle_x_mm.value_or(0));
}

/// They lie on the line, so that they are the same for both sides.
void AddAlignmentHoles(const CourseFileOptions& options, double line_x_mm,
                       CourseFiles& files, Warnings& warnings) {
  if (options.alignment_y_mm.empty()) return;
  std::vector<std::string> places;
  for (const double y_mm : options.alignment_y_mm) {
    files.holes.push_back({Vec2(line_x_mm, y_mm), options.alignment_diameter_mm});
    places.push_back(fmt::format("({:.6g}, {:.6g})", line_x_mm, y_mm));
  }
  warnings.push_back(MakeWarning(
      WarningCode::kChosen,
      fmt::format(
          "alignment holes of {:g} mm at {} mm, on the line about which the board "
          "is turned over: drill them into what it lies on, too, and put pins "
          "into them; leave --align out for the other side",
          options.alignment_diameter_mm, fmt::join(places, " and "))));
}

void MirrorToSide(const CourseFileOptions& options, const CourseSide& side,
                  CourseFiles& files, Warnings& warnings) {
  const bool is_back = !side.back.empty();
  if (options.mirror.value_or(is_back)) {
    const double line_x_mm = LineOf(options, side);
    MirrorFiles(line_x_mm, files);
    warnings.push_back(MakeWarning(
        WarningCode::kChosen,
        fmt::format("{}all is mirrored about the line x = {:.6g} mm (--mirror-x); "
                    "turn the board over about it",
                    is_back ? side.back + " draws the back as seen from the front: " : "",
                    line_x_mm)));
    return;
  }
  if (!is_back) return;
  Warning warning = MakeWarning(
      WarningCode::kOther,
      side.back +
          " draws the back as seen from the front and is not mirrored: parts will not "
          "fit, unless the file is mirrored already; leave --mirror out");
  warning.weight = WarningWeight::kWarning;
  warnings.push_back(std::move(warning));
}

}  // namespace

void TurnToSide(const CourseFileOptions& options, const CourseSide& side,
                CourseFiles& files, Warnings& warnings) {
  MirrorToSide(options, side, files, warnings);
  AddAlignmentHoles(options, LineOf(options, side), files, warnings);
}

}  // namespace intaglio
