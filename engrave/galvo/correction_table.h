#pragma once

// A correction of the field by a grid, between whose nodes it is interpolated:
//   four triangles  each cell in four triangles around the mean of its corners
//                   (Bessmeltsev, Goloshevsky, Smirnov 2009, (3)-(6), corrected: the sums
//                   are divided by the pitch, and i runs along x)
//   bilinear        10 to 15 % nearer than four triangles; also for tables of others,
//                   which are often kinked along the axes
//   spline          bicubic, twice continuously differentiable, third derivative
//                   continuous at the second node from each side (not-a-knot; de Boor,
//                   A Practical Guide to Splines, 1978, ch. IV): for what is smooth, 100
//                   times nearer; 4 nodes a side or more
// All pass through the nodes. Outside the grid the value of its nearest place holds.

#include "engrave/galvo/field_grid.h"

namespace intaglio::galvo {

enum class Interpolation { kFourTriangles, kBilinear, kSpline };

class CorrectionTable {
 public:
  /// Errors as of CheckGrid; kInvalidValue for a spline of less than 4 nodes a side.
  static Result<CorrectionTable> Make(FieldGrid grid, Interpolation interpolation);

  /// The correction there, mm. Neither allocates nor throws: for each tick.
  Vec2 At(const Vec2& place_mm) const;

  const FieldGrid& grid() const { return grid_; }

 private:
  CorrectionTable(FieldGrid grid, Interpolation interpolation);
  Vec2 SplineAt(int i, int j, double u, double v) const;

  FieldGrid grid_;
  Interpolation interpolation_;
  double per_mm_;
  // Of a spline: (nodes + 2)^2 weights of the uniform cubic B-splines, row by row.
  std::vector<Vec2> weights_mm_;
};

/// The correction there; beyond the border it goes on with the slope that it has there.
Vec2 ContinuedAt(const CorrectionTable& table, const Vec2& place_mm);

/// Where to command so that the beam arrives at `target_mm`, when a command at u arrives
/// at u + deviations(u): the solution of u = t - deviations(u). The source subtracts
/// deviations(t), which is off by its slope times it: 170 um of 3 mm over 100 mm.
/// Beyond the border the deviations are those of ContinuedAt.
/// kInvalidValue: deviations that change as fast as the place have no single solution.
Result<Vec2> CommandFor(const Vec2& target_mm, const CorrectionTable& deviations);

/// Commands minus targets at the nodes of a grid of `nodes` a side over that of the
/// deviations: a table for At(), which needs no iteration. Errors as of CommandFor.
Result<FieldGrid> CommandGrid(const CorrectionTable& deviations, int nodes);

}  // namespace intaglio::galvo
