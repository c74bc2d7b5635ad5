#include "services/job/course/course_tabs.h"

#include <utility>
#include <vector>

#include "engrave/contour/milling/cut_tabs.h"
#include "engrave/core/try.h"

namespace intaglio {

contour::TabOptions TabsOf(const Course& course) {
  contour::TabOptions tabs;
  tabs.count = static_cast<int>(course.tab_count());
  if (course.has_tab_distance_mm()) tabs.distance_mm = course.tab_distance_mm();
  tabs.width_mm = course.tab_width_mm();
  return tabs;
}

Result<post::ToolPath> PathWithTabs(const Course& course, const contour::Edges& edges,
                                    std::string name) {
  const contour::TabOptions options = TabsOf(course);
  if (options.count == 0 && !options.distance_mm)
    return post::PathOf(edges, std::move(name));
  auto pieces = contour::PiecesWithTabs(edges, options, course.tool_diameter_mm());
  if (!pieces) {
    Error error = pieces.error();
    error.message = name + ": " + error.message;
    return tl::unexpected(error);
  }
  contour::Edges divided;
  std::vector<bool> tabs;
  for (const contour::CutPiece& piece : *pieces) {
    divided.push_back(piece.edge);
    tabs.push_back(piece.tab);
  }
  return post::PathOf(divided, std::move(name), 0, tabs);
}

}  // namespace intaglio
