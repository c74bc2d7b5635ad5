#pragma once

// The published law of corner speed: the error of a corner by a formula, its speed from
// the tolerance. Kept for comparison: the formula ignores the orientation, the order of
// the axes and the acceleration, and is wrong by -62 to +716 % over its whole range; with
// the whole tolerance the worst corner of a program is at 1.7 times it. Plan with
// plan.h, which predicts the contour.
//
// Source: Zarudnev 2007, (6)-(8).

#include <vector>

#include "engrave/course/axis_dynamics.h"
#include "engrave/course/path.h"

namespace intaglio::course {

/// The share of the tolerance with which the law held 100 um both ways on the measured
/// program (docs/measurements.md).
inline constexpr double kSourceAllowanceRatio = 0.45;

/// delta / V, s = f1 (|xi - .25| + .25) (1.5 |1 / w_min - 1 / w_max| + 1 / (2 w_c)), f1 =
/// sin(turn) below 90 degrees, else 1; xi of the axis with the lower frequency. turn
/// 0..pi.
double SourceCornerError(double turn_rad, double slow_damping_ratio,
                         double natural_1_rad_s, double natural_2_rad_s);

struct SourceLawOptions {
  double tolerance_mm = 0.1;
  /// 1: as published.
  double allowance_ratio = kSourceAllowanceRatio;
  /// Chains of chords that turn by less than 20 degrees each are curves; a limit by their
  /// curvature too. The source has none, and cuts a curve wrong whose corners are all
  /// allowed.
  bool limit_curves = true;
};

/// The speed limit of each inner node, mm/s; may be infinite. Both axes have elastic
/// mechanics.
std::vector<double> SourceNodeSpeeds(const Path& path, const AxisPair& axes,
                                     const SourceLawOptions& options);

}  // namespace intaglio::course
