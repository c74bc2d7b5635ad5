#pragma once

// A scan head from a measured grid of marks: ten numbers that explain it (head_model.h),
// and what they leave, as a smooth surface, where that is more than chance.
//
// A table of the measured deviations themselves has the noise of the camera at every
// node: over 100 mm with 9 x 9 marks and 5 um of noise four triangles are wrong by 67 um,
// a spline by 18, the ten numbers by 4.3.
//
//   Levenberg-Marquardt (Marquardt 1963, An Algorithm for Least-Squares Estimation of
//   Nonlinear Parameters); cross-validation (Stone 1974, Cross-Validatory Choice and
//   Assessment of Statistical Predictions); intervals as of Seber and Wild, Nonlinear
//   Regression, 1989, ch. 2.

#include <span>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/head_model.h"

namespace intaglio::galvo {

/// A mark of the grid, mm: what was commanded, and where it was measured. Grids may have
/// gaps; they need not be regular.
struct GridMark {
  Vec2 command_mm = Vec2::Zero();
  Vec2 measured_mm = Vec2::Zero();
};

struct HeadFit {
  HeadModel model;
  std::array<double, kHeadModelNumbers> interval95{};  ///< +- of each number
  double sigma_mm = 0;  ///< standard deviation of a coordinate of a mark
  /// Of marks that the fit had not seen (five-fold), root of the mean square of a
  /// coordinate: of the numbers alone, and with the best residual surface.
  double unseen_rms_mm = 0, unseen_rms_with_surface_mm = 0;
  /// Cells a side of the residual surface; 0: none is significant.
  int surface_cells = 0;
  FieldGrid surface;               ///< of nodes to be joined by a spline, if there is one
  std::vector<Vec2> residuals_mm;  ///< one a mark: measured minus fitted
  std::vector<bool> used;          ///< one a mark; false: too far from all others
};

struct HeadFitOptions {
  double width_mm = 0;  ///< of the field, > 0
  double focal_mm = 0;  ///< mm of command per rad, optical, > 0
};

/// kMissing: fewer than 16 marks that are used. kInvalidValue: a mark that is no number
/// or outside the field, marks that do not determine the numbers, or that cannot be those
/// of their commands (grid_sense.h).
Result<HeadFit> FitHead(std::span<const GridMark> marks, const HeadFitOptions& options);

/// Where a command arrives, by model and surface: in the measured frame, mm.
Vec2 ArrivalOf(const HeadFit& fit, const Vec2& command_mm);

/// Where a command arrives, minus the command: model and surface at the nodes of a grid
/// over the field, for CorrectionTable (spline).
FieldGrid DeviationsOf(const HeadFit& fit, double width_mm, int nodes);

}  // namespace intaglio::galvo
