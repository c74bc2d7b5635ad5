#include "engrave/discretize/spacing/contour_points.h"

#include <algorithm>
#include <cmath>

namespace intaglio::discretize {
namespace {

double ArcOf(const ContourSteps& steps, std::size_t i) {
  return steps.first_mm + steps.step_mm * static_cast<double>(i);
}

/// The first step at or behind arc_mm, exactly.
std::size_t FirstStepFrom(double arc_mm, const ContourSteps& steps) {
  const double near = std::ceil((arc_mm - steps.first_mm) / steps.step_mm);
  const auto limit = static_cast<double>(steps.count);
  auto i = static_cast<std::size_t>(std::clamp(near, 0.0, limit));
  while (i > 0 && ArcOf(steps, i - 1) >= arc_mm) --i;
  while (i < steps.count && ArcOf(steps, i) < arc_mm) ++i;
  return i;
}

}  // namespace

ContourSteps StepsAlong(double length_mm, bool closed, const ContourSpacing& spacing) {
  const double fitting = length_mm / (spacing.distance_mm * kChordAllowance);
  if (!(fitting >= 1)) return {closed ? 0 : length_mm / 2, length_mm, 1, false};
  const double parts = std::floor(fitting);
  const double step_mm = length_mm / parts;
  const auto count = static_cast<std::size_t>(parts);
  if (closed) return {spacing.phase_ratio * step_mm, step_mm, count, false};
  if (spacing.insert_end_points) return {0, step_mm, count, true};
  const double phase = 0.5 + spacing.phase_ratio;
  return {(phase - std::floor(phase)) * step_mm, step_mm, count, false};
}

void AddSteps(const MeasuredContour& contour, const ContourSteps& steps,
              std::size_t begin, std::size_t end, PointList& points) {
  const std::span<const Vec3> corner = contour.points_mm;
  const bool at_end = end >= contour.segment_count();
  std::size_t i = begin == 0 ? 0 : FirstStepFrom(contour.arc_mm[begin], steps);
  const std::size_t stop =
      at_end ? steps.count : FirstStepFrom(contour.arc_mm[end], steps);
  if (i < stop) {
    const std::size_t before = points.size();
    points.resize(before + stop - i);
    Vec3* point = points.data() + before;
    double arc_mm = ArcOf(steps, i);
    for (std::size_t segment = begin; segment < end; ++segment) {
      const double end_mm = contour.arc_mm[segment + 1];
      if (arc_mm >= end_mm) continue;
      const double begin_mm = contour.arc_mm[segment];
      const Vec3 from = corner[segment];
      const Vec3 direction = (corner[segment + 1] - from) / (end_mm - begin_mm);
      do {
        *point++ = from + direction * (arc_mm - begin_mm);
        arc_mm = ArcOf(steps, ++i);
      } while (arc_mm < end_mm && i < stop);
      if (i == stop) break;
    }
    // A contour without length, or an end that rounding put behind the last segment.
    for (; i < stop; ++i) *point++ = corner.back();
  }
  if (at_end && steps.end_point) points.push_back(corner.back());
}

void AddContourPoints(const PointList& contour_mm, bool closed,
                      const ContourSpacing& spacing, PointList& points) {
  if (contour_mm.empty()) return;
  PointList corners = contour_mm;
  if (closed) corners.push_back(contour_mm.front());
  std::vector<double> arc_mm(corners.size(), 0);
  for (std::size_t i = 1; i < corners.size(); ++i) {
    arc_mm[i] = arc_mm[i - 1] + (corners[i] - corners[i - 1]).norm();
  }
  const MeasuredContour contour = {corners, arc_mm};
  AddSteps(contour, StepsAlong(arc_mm.back(), closed, spacing), 0,
           contour.segment_count(), points);
}

}  // namespace intaglio::discretize
