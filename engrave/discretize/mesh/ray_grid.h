#pragma once

#include <cmath>
#include <cstdint>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::discretize {

/// Parallel rays by columns and rows, in their own frame (u, v, w): w runs along them.
struct RayGrid {
  /// A power of two, 2^-50 of the reach or so (about 1e-12 mm). Places of rays, and of
  /// the corners that are compared with them, are multiples of it: their differences are
  /// exact in doubles, and products of those in 113 bits.
  double unit_mm = 1;
  double u0_mm = 0, v0_mm = 0;          ///< ray (0, 0)
  double step_u_mm = 1, step_v_mm = 1;  ///< from ray to ray
  std::uint32_t column_count = 0, row_count = 0;

  double Rounded(double mm) const { return std::nearbyint(mm / unit_mm) * unit_mm; }
  double U(std::uint32_t column) const {
    return u0_mm + static_cast<double>(column) * step_u_mm;
  }
  double V(std::uint32_t row) const {
    return v0_mm + static_cast<double>(row) * step_v_mm;
  }
  /// The first column at u or behind it, and the first row at v or behind it.
  std::uint32_t ColumnFrom(double u_mm) const;
  std::uint32_t RowFrom(double v_mm) const;

  /// A grid of the same steps, shifted by half a step along both axes, that covers the
  /// same area.
  RayGrid Between() const;
};

/// Over a box in the rays' frame, centred; steps positive. kTooLarge for more than 2^27
/// rays, or 2^24 in a row.
Result<RayGrid> GridOver(const Box3& bounds, double step_u_mm, double step_v_mm);

/// The rays at multiples of a positive step in both directions that lie within a box;
/// none where it lies between two. kTooLarge as above.
Result<RayGrid> GridThroughOrigin(const Box3& bounds, double step_mm);

}  // namespace intaglio::discretize
