#pragma once

// What is wrong with the axes x and y of a machine, from marks that were passed in known
// directions at known speeds (approach.h). A mark that is to be at n, passed with the
// velocity v and the directions d, lies at
//   m = t + F n - 1/2 b d - tau v + noise            (products of b, tau by component)
// in the frame in which it is measured: F has scales, squareness and the rotation of that
// frame, b is the backlash of each axis, tau how much later than compensated each axis
// is. Least squares; marks that do not belong to it are left out.
//
//   ISO 230-2:2014 for the words (backlash: reversal value; repeatability); Huber 1964,
//   Robust Estimation of a Location Parameter, for the start of the fit.

#include <array>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

/// A mark, mm and mm/s. Frame glass, or one parallel to the axes.
struct PassedMark {
  Vec2 place_mm = Vec2::Zero();     ///< where it was to be
  Vec2 speed_mm_s = Vec2::Zero();   ///< velocity there
  Vec2 direction = Vec2::Zero();    ///< 1, -1; 0: not known, this coordinate is not used
  Vec2 measured_mm = Vec2::Zero();  ///< where it is
};

/// A value and its uncertainty: `value` is within +-`interval95` with 95 % probability.
struct Figure {
  double value = 0;
  double interval95 = 0;
};

struct AxisFigures {
  Figure scale_ratio;       ///< how far it goes for 1 mm
  Figure backlash_mm;       ///< >= 0 but for noise
  Figure lag_s;             ///< later than it was compensated for
  Figure repeatability_mm;  ///< standard deviation of a mark
  int used_count = 0;       ///< marks of the fit
  int rejected_count = 0;   ///< marks that do not belong to it
};

/// Scales and squareness of the axes before the measurement, which the places were made
/// with (machine::CartesianOptions).
struct KnownGeometry {
  double x_scale_ratio = 1, y_scale_ratio = 1;
  double squareness_rad = 0;
};

struct MachineFit {
  std::array<AxisFigures, 2> axes;  ///< x, y
  /// How much less than a right angle + of x and + of y enclose.
  Figure squareness_rad;
  double rotation_rad = 0;  ///< of the frame of the measurement, counterclockwise
  Vec2 offset_mm = Vec2::Zero();
  /// One a mark: measured minus fitted, mm; 0 of a coordinate that was not used.
  std::vector<Vec2> residuals_mm;
  /// One a mark: where it is in the frame of the places, without offset and rotation,
  /// minus where it was to be.
  std::vector<Vec2> deviations_mm;
};

/// Scales and squareness are the whole ones, what was `known` included: what a profile
/// has to have. kMissing with what is missing when the marks do not determine a figure;
/// kInvalidValue for coordinates that are no numbers.
Result<MachineFit> FitMachine(const std::vector<PassedMark>& marks,
                              const KnownGeometry& known = {});

}  // namespace intaglio::calibrate
