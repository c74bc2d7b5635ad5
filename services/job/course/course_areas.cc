#include "services/job/course/course_areas.h"

#include <utility>

#include "engrave/contour/milling/cut.h"
#include "engrave/contour/milling/pocket.h"
#include "engrave/contour/region/region.h"
#include "engrave/contour/union.h"
#include "engrave/core/try.h"

namespace intaglio {
namespace {

Result<contour::Region> AreaOfAll(const std::vector<contour::Element>& areas) {
  return contour::RegionOf(
      INTAGLIO_TRY(contour::Unite(areas, {0, contour::Corners::kRound})));
}

}  // namespace

Result<AreaPaths> ClearAreas(const Course& course,
                             const std::vector<contour::Element>& areas) {
  contour::PocketOptions options;
  options.tool_diameter_mm = course.tool_diameter_mm();
  options.step_ratio = 1 - course.overlap_ratio();
  const contour::Region region = INTAGLIO_TRY(AreaOfAll(areas));
  AreaPaths made;
  for (const contour::Region& part : contour::ConnectedParts(region)) {
    auto pocket = INTAGLIO_TRY(contour::ClearPocket(part, options));
    made.left_mm2 += pocket.left_area_mm2;
    int pass = 0;
    for (contour::PocketPass& row : pocket.passes) {
      for (contour::Edges& path : row.paths) {
        made.paths.push_back(std::move(path));
        made.passes.push_back(pass);
      }
      ++pass;
    }
  }
  return made;
}

Result<AreaPaths> CutAreas(const Course& course,
                           const std::vector<contour::Element>& areas) {
  contour::CutOptions options;
  options.tool_diameter_mm = course.tool_diameter_mm();
  options.side = course.inside() ? contour::CutSide::kInside : contour::CutSide::kOutside;
  if (course.has_lead_mm()) {
    options.lead = contour::LeadKind::kArc;
    options.lead_mm = course.lead_mm();
  }
  const contour::Region region = INTAGLIO_TRY(AreaOfAll(areas));
  AreaPaths made;
  for (const contour::Cut& cut : INTAGLIO_TRY(contour::CutOut(region, options))) {
    made.paths.push_back(contour::PathOf(cut));
    made.passes.push_back(0);
  }
  return made;
}

}  // namespace intaglio
