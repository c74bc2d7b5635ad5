#include "engrave/contour/drill_plan.h"

#include <algorithm>
#include <numeric>

namespace intaglio::contour {
namespace {

constexpr double kSameTool_mm = 1e-3;

}  // namespace

std::vector<DrillTool> PlanDrilling(std::span<const Hole> holes, const Vec2& start_mm,
                                    OrderKind kind, const ImproveOptions& options) {
  VisitOrder growing(holes.size());
  std::iota(growing.begin(), growing.end(), 0U);
  std::stable_sort(growing.begin(), growing.end(), [&](std::uint32_t a, std::uint32_t b) {
    return holes[a].diameter_mm < holes[b].diameter_mm;
  });
  std::vector<DrillTool> tools;
  Vec2 at = start_mm;
  for (auto begin = growing.begin(); begin != growing.end();) {
    const double diameter = holes[*begin].diameter_mm;
    const auto end = std::find_if(begin, growing.end(), [&](std::uint32_t k) {
      return holes[k].diameter_mm > diameter + kSameTool_mm;
    });
    std::sort(begin, end);  // ties go to the lower number
    std::vector<Vec2> places;
    for (auto k = begin; k != end; ++k) places.push_back(holes[*k].center_mm);
    VisitOrder order = NearestOrder(places, at);
    if (kind == OrderKind::kImproved) ImproveOrder(places, at, order, options);
    at = places[order.back()];
    for (std::uint32_t& visit : order) visit = begin[visit];
    tools.push_back({diameter, std::move(order)});
    begin = end;
  }
  return tools;
}

}  // namespace intaglio::contour
