#include "engrave/contour/drill_plan.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace intaglio::contour {
namespace {

constexpr double kSameTool_mm = 1e-3;

/// The shortest way found from `at_mm` through these holes, and where it ends.
void AppendTurn(std::span<const Hole> holes, std::span<const std::uint32_t> numbers,
                OrderKind kind, const ImproveOptions& options, Vec2& at_mm,
                VisitOrder& visits) {
  std::vector<Vec2> places;
  for (const std::uint32_t k : numbers) places.push_back(holes[k].center_mm);
  VisitOrder order = NearestOrder(places, at_mm);
  if (kind == OrderKind::kImproved) ImproveOrder(places, at_mm, order, options);
  at_mm = places[order.back()];
  for (const std::uint32_t visit : order) visits.push_back(numbers[visit]);
}

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
    // Of one turn, ties go to the lower number.
    std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(holes[a].turn, a) < std::pair(holes[b].turn, b);
    });
    DrillTool tool{diameter, {}};
    while (begin != end) {
      const auto next = std::find_if(begin, end, [&](std::uint32_t k) {
        return holes[k].turn != holes[*begin].turn;
      });
      AppendTurn(holes, {begin, next}, kind, options, at, tool.holes);
      begin = next;
    }
    tools.push_back(std::move(tool));
  }
  return tools;
}

}  // namespace intaglio::contour
