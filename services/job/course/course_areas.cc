#include "services/job/course/course_areas.h"

#include <algorithm>
#include <utility>

#include "engrave/contour/milling/cut.h"
#include "engrave/contour/milling/pocket.h"
#include "engrave/contour/milling/pocket_order.h"
#include "engrave/contour/region/region.h"
#include "engrave/contour/union.h"
#include "engrave/core/try.h"
#include "services/job/course/course_tabs.h"

namespace intaglio {
namespace {

/// As long as PathOf(cut).
std::vector<bool> TabsAlong(const contour::Cut& cut) {
  std::vector<bool> tabs(cut.lead_in.size(), false);
  for (const contour::CutPiece& piece : cut.pieces) tabs.push_back(piece.tab);
  tabs.resize(tabs.size() + cut.lead_out.size(), false);
  return tabs;
}

Result<contour::Region> AreaOfAll(const std::vector<contour::Element>& areas) {
  return contour::RegionOf(
      INTAGLIO_TRY(contour::Unite(areas, {0, contour::Corners::kRound})));
}

}  // namespace

Result<AreaPaths> ClearAreas(const Course& course,
                             const std::vector<contour::Element>& areas,
                             const Vec2& start_mm) {
  contour::PocketOptions options;
  options.tool_diameter_mm = course.tool_diameter_mm();
  options.step_ratio = 1 - course.overlap_ratio();
  const contour::Region region = INTAGLIO_TRY(AreaOfAll(areas));
  AreaPaths made;
  for (const contour::Region& part : contour::ConnectedParts(region)) {
    auto pocket = INTAGLIO_TRY(contour::ClearPocket(part, options));
    made.left_mm2 += pocket.left_area_mm2;
    made.left_at_wall_mm = std::max(made.left_at_wall_mm, pocket.tolerance_mm);
    const Vec2 at_mm = made.paths.empty() ? start_mm : made.paths.back().back().end_mm;
    for (contour::PocketStep& step : contour::OrderPocket(pocket, at_mm)) {
      made.paths.push_back(std::move(step.path));
      made.passes.push_back(static_cast<int>(step.pass));
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
  options.tabs = TabsOf(course);
  const contour::Region region = INTAGLIO_TRY(AreaOfAll(areas));
  AreaPaths made;
  for (const contour::Cut& cut : INTAGLIO_TRY(contour::CutOut(region, options))) {
    made.paths.push_back(contour::PathOf(cut));
    made.tabs.push_back(TabsAlong(cut));
    made.passes.push_back(0);
  }
  return made;
}

}  // namespace intaglio
