#include "services/job/course/course_nets.h"

#include <fmt/format.h>

#include "engrave/contour/region/region.h"
#include "engrave/contour/union.h"
#include "engrave/core/geometry.h"
#include "engrave/core/try.h"

namespace intaglio {
namespace {

constexpr std::size_t kMaxNamedFaults = 5;

Result<contour::Region> DrawnOn(const DrawnNets& drawn, std::uint32_t layer) {
  std::vector<contour::Element> elements;
  for (const contour::NetElement& one : drawn.elements) {
    if ((one.layers >> layer & 1) != 0) elements.push_back(one.element);
  }
  if (elements.empty()) return contour::Region{};
  return contour::RegionOf(
      INTAGLIO_TRY(contour::Unite(elements, {0, contour::Corners::kRound})));
}

/// Copper that reaches beyond everything that the tool sweeps.
Result<contour::Region> SheetAround(const contour::Isolation& isolation,
                                    double tool_diameter_mm) {
  Vec2 min = Vec2::Constant(1e9), max = Vec2::Constant(-1e9);
  for (const contour::IsolationPass& pass : isolation.passes) {
    for (const contour::Contour& contour : pass.contours) {
      for (const contour::Edge& edge : contour.edges) {
        // An arc is no farther from its ends than it is long.
        const double reach_mm = contour::LengthOf({edge}) + 2 * tool_diameter_mm + 1;
        min = min.cwiseMin(edge.begin_mm.array().matrix() - Vec2::Constant(reach_mm));
        max = max.cwiseMax(edge.begin_mm.array().matrix() + Vec2::Constant(reach_mm));
      }
    }
  }
  const Vec2 low_right(max.x(), min.y()), high_left(min.x(), max.y());
  return contour::RegionOfLoops(
      {{contour::MakeLine(min, low_right), contour::MakeLine(low_right, max),
        contour::MakeLine(max, high_left), contour::MakeLine(high_left, min)}});
}

}  // namespace

Result<contour::NetReport> ProveNets(const DrawnNets& drawn,
                                     const contour::Isolation& isolation,
                                     double tool_diameter_mm) {
  std::vector<contour::Region> copper;
  for (std::uint32_t layer = 0; layer < drawn.layers.size(); ++layer) {
    if (layer != drawn.layer) {
      copper.push_back(INTAGLIO_TRY(DrawnOn(drawn, layer)));
      continue;
    }
    const contour::Region sheet = INTAGLIO_TRY(SheetAround(isolation, tool_diameter_mm));
    copper.push_back(
        INTAGLIO_TRY(contour::CopperLeft(sheet, isolation, tool_diameter_mm)));
  }
  auto report = INTAGLIO_TRY(contour::CompareNets(copper, drawn.elements));
  if (report.faults.empty()) return report;
  std::string why = drawn.file + ": the copper that is left has not the nets of the file";
  for (std::size_t i = 0; i < std::min(report.faults.size(), kMaxNamedFaults); ++i)
    why += (i == 0 ? ": " : "; ") + report.faults[i].sentence;
  if (report.faults.size() > kMaxNamedFaults)
    why += fmt::format("; and {} more", report.faults.size() - kMaxNamedFaults);
  return Fail(ErrorCode::kUnsupported, why, drawn.file);
}

}  // namespace intaglio
