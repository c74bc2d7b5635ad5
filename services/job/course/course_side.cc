#include "services/job/course/course_side.h"

#include <fmt/format.h>

#include <utility>

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

}  // namespace

void TurnToSide(const CourseFileOptions& options, const CourseSide& side,
                CourseFiles& files, Warnings& warnings) {
  const bool is_back = !side.back.empty();
  if (options.mirror.value_or(is_back)) {
    const double line_x_mm = options.mirror_x_mm.value_or(side.middle_x_mm.value_or(0));
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

}  // namespace intaglio
