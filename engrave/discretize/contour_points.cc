#include "engrave/discretize/contour_points.h"

#include <algorithm>
#include <cmath>

namespace intaglio::discretize {
namespace {

// A chord is shorter than its arc s on a radius R by s^2 / 24 R^2: with this much more
// arc the chord still reaches the distance down to bends of R = 3.2 s, and the weld,
// which measures chords, keeps the points.
constexpr double kChordAllowance = 1.004;

std::vector<double> ArcLengths(const PointList& contour_mm, bool closed) {
  std::vector<double> length = {0};
  for (std::size_t i = 1; i < contour_mm.size() + (closed ? 1 : 0); ++i) {
    const Vec3& next = contour_mm[i % contour_mm.size()];
    length.push_back(length.back() + (next - contour_mm[i - 1]).norm());
  }
  return length;
}

}  // namespace

void AddContourPoints(const PointList& contour_mm, bool closed,
                      const ContourSpacing& spacing, PointList& points) {
  if (contour_mm.empty()) return;
  const std::vector<double> length = ArcLengths(contour_mm, closed);
  const double total = length.back();
  const double fitting = total / (spacing.distance_mm * kChordAllowance);
  const auto parts = static_cast<std::size_t>(std::max(1.0, std::floor(fitting)));
  const double step = total / static_cast<double>(parts);
  // A closed contour begins anywhere; an open one keeps its ends, or stays half a step
  // off.
  const bool one_point = fitting < 1;
  double first = closed ? spacing.phase_ratio * step : 0;
  std::size_t count = closed || one_point ? parts : parts + 1;
  if (one_point) {
    first = closed ? 0 : total / 2;
  } else if (!closed && !spacing.insert_end_points) {
    first = step / 2;
    count = parts;
  }
  std::size_t segment = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = std::min(total, first + step * static_cast<double>(i));
    while (segment + 2 < length.size() && length[segment + 1] < at) ++segment;
    const Vec3& p = contour_mm[segment];
    const Vec3& q = contour_mm[(segment + 1) % contour_mm.size()];
    const double part =
        segment + 1 < length.size() ? length[segment + 1] - length[segment] : 0;
    points.push_back(part > 0 ? Vec3(p + (q - p) * ((at - length[segment]) / part)) : p);
  }
}

}  // namespace intaglio::discretize
