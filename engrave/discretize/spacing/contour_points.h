#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

/// A chord is shorter than its arc s on a radius R by s^2 / 24 R^2: with this much more
/// arc the chord is still at least the distance for bends down to R = 3.2 s, and
/// thinning, which measures chords, keeps the points.
inline constexpr double kChordAllowance = 1.004;

struct ContourSpacing {
  double distance_mm = 1;  ///< wanted along the contour
  double phase_ratio = 0;  ///< of the distance, by which the points are shifted
  bool insert_end_points = true;
};

/// Where the points of a contour lie: at first + i step along it for i < count, and at
/// its end.
struct ContourSteps {
  double first_mm = 0;
  double step_mm = 1;
  std::size_t count = 0;
  bool end_point = false;

  std::size_t point_count() const { return count + (end_point ? 1 : 0); }
};

/// Equal arc length. The remainder is spread evenly. So the distance is never below the
/// requested one, except as a chord on sharp bends, and above it by less than one part in
/// the number of points plus 0.4 %. A contour shorter than the distance gets one point.
/// The points of an open contour that keeps its ends do not depend on the phase.
ContourSteps StepsAlong(double length_mm, bool closed, const ContourSpacing& spacing);

/// Points along which the arc length is known; a closed one ends in its first point.
struct MeasuredContour {
  std::span<const Vec3> points_mm;
  std::span<const double> arc_mm;  ///< of each point, from 0 on, never falling

  std::size_t segment_count() const { return points_mm.size() - 1; }
};

/// Appends the points that lie on segments begin to end of the contour; the points of all
/// its segments are always the same, bit for bit, however the segments are divided among
/// calls.
void AddSteps(const MeasuredContour& contour, const ContourSteps& steps,
              std::size_t begin, std::size_t end, PointList& points);

/// The points of a whole polyline, appended to `points`. A closed one need not repeat its
/// first point.
void AddContourPoints(const PointList& contour_mm, bool closed,
                      const ContourSpacing& spacing, PointList& points);

}  // namespace intaglio::discretize
