#include "tests/integration/course/tool_way.h"

#include <algorithm>
#include <cmath>
#include <fstream>

namespace intaglio::testing {

std::vector<ToolStep> ReadToolWay(const std::filesystem::path& file) {
  std::vector<ToolStep> way;
  std::ifstream in(file);
  ToolStep step;
  while (in >> step.end_us >> step.to_mm.x() >> step.to_mm.y() >> step.to_mm.z() >>
         step.on >> step.power) {
    if (step.to_mm != step.from_mm) way.push_back(step);
    step.from_mm = step.to_mm;
    step.begin_us = step.end_us;
  }
  return way;
}

double DistanceToStep(const Vec2& place_mm, const ToolStep& step) {
  const Vec2 from = step.from_mm.head<2>(), way = step.to_mm.head<2>() - from;
  const double along =
      way.norm() > 0
          ? std::clamp((place_mm - from).dot(way) / way.squaredNorm(), 0.0, 1.0)
          : 0;
  return (from + along * way - place_mm).norm();
}

double DistanceToWay(const Vec2& place_mm, const std::vector<ToolStep>& way) {
  double nearest_mm = 1e9;
  for (const ToolStep& step : way)
    nearest_mm = std::min(nearest_mm, DistanceToStep(place_mm, step));
  return nearest_mm;
}

std::vector<Vec2> PlacesOn(const ToolStep& step, double spacing_mm) {
  const Vec2 from = step.from_mm.head<2>(), way = step.to_mm.head<2>() - from;
  const int count = std::max(1, static_cast<int>(std::ceil(way.norm() / spacing_mm)));
  std::vector<Vec2> places;
  for (int i = 0; i <= count; ++i) places.emplace_back(from + way * i / count);
  return places;
}

std::size_t VisitsOf(const Vec2& place_mm, const std::vector<ToolStep>& way,
                     double near_mm) {
  std::size_t visits = 0;
  bool by = false;
  for (const ToolStep& step : way) {
    const bool is_by = DistanceToStep(place_mm, step) < near_mm;
    visits += is_by && !by;
    by = is_by;
  }
  return visits;
}

}  // namespace intaglio::testing
