#include "engrave/discretize/contour_points.h"

#include <algorithm>
#include <cmath>

namespace intaglio::discretize {
namespace {

// A chord is shorter than its arc s on a radius R by s^2 / 24 R^2: with this much more
// arc the chord still reaches the distance down to bends of R = 3.2 s, and the weld,
// which measures chords, keeps the points.
constexpr double kChordAllowance = 1.004;

double LengthOf(const PointList& contour_mm, bool closed) {
  double length_mm = closed ? (contour_mm.front() - contour_mm.back()).norm() : 0;
  for (std::size_t i = 1; i < contour_mm.size(); ++i) {
    length_mm += (contour_mm[i] - contour_mm[i - 1]).norm();
  }
  return length_mm;
}

/// `count` points from `first_mm` on, `step_mm` apart along the contour.
void AddAtSteps(const PointList& contour_mm, bool closed, double first_mm, double step_mm,
                std::size_t count, PointList& points) {
  const std::size_t segments = contour_mm.size() - (closed ? 0 : 1);
  std::size_t i = 0;
  double begin_mm = 0;
  for (std::size_t segment = 0; segment < segments && i < count; ++segment) {
    const Vec3& p = contour_mm[segment];
    const Vec3 way = contour_mm[(segment + 1) % contour_mm.size()] - p;
    const double length_mm = way.norm(), end_mm = begin_mm + length_mm;
    double at_mm = first_mm + step_mm * static_cast<double>(i);
    if (at_mm < end_mm) {
      const Vec3 direction = way / length_mm;
      while (at_mm < end_mm && i < count) {
        points.push_back(p + direction * (at_mm - begin_mm));
        at_mm = first_mm + step_mm * static_cast<double>(++i);
      }
    }
    begin_mm = end_mm;
  }
  // A contour without length, or an end that rounding put behind the last segment.
  for (; i < count; ++i) points.push_back(contour_mm.back());
}

}  // namespace

void AddContourPoints(const PointList& contour_mm, bool closed,
                      const ContourSpacing& spacing, PointList& points) {
  if (contour_mm.empty()) return;
  const double total = LengthOf(contour_mm, closed);
  const double fitting = total / (spacing.distance_mm * kChordAllowance);
  const auto parts = static_cast<std::size_t>(std::max(1.0, std::floor(fitting)));
  const double step = total / static_cast<double>(parts);
  if (fitting < 1) {
    AddAtSteps(contour_mm, closed, closed ? 0 : total / 2, step, 1, points);
  } else if (closed) {
    AddAtSteps(contour_mm, closed, spacing.phase_ratio * step, step, parts, points);
  } else if (spacing.insert_end_points) {
    AddAtSteps(contour_mm, closed, 0, step, parts, points);
    points.push_back(contour_mm.back());
  } else {
    AddAtSteps(contour_mm, closed, step / 2, step, parts, points);
  }
}

}  // namespace intaglio::discretize
