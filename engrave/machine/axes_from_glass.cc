#include "engrave/machine/axes_from_glass.h"

#include <cmath>

#include "engrave/core/try.h"

namespace intaglio::machine {
namespace {

constexpr int kGrid = 64;

}  // namespace

// To and fro, so that each place is near the one before.
Result<Box3> AxesOver(const AxesFromGlass& axes_from_glass, const Box3& glass_mm,
                      const Box3& travel) {
  const auto along = [&](int axis, int i) {
    return std::lerp(glass_mm.min_mm[axis], glass_mm.max_mm[axis],
                     static_cast<double>(i) / kGrid);
  };
  Box3 needed;
  Vec3 near = BranchStart(travel);
  for (const double z_mm : {glass_mm.min_mm.z(), glass_mm.max_mm.z()}) {
    for (int row = 0; row <= kGrid; ++row) {
      for (int i = 0; i <= kGrid; ++i) {
        const int column = row % 2 == 0 ? i : kGrid - i;
        const auto axes = INTAGLIO_TRY(
            axes_from_glass.ToAxes(Vec3(along(0, column), along(1, row), z_mm), near));
        needed.Extend(axes);
        near = axes;
      }
    }
  }
  return needed;
}

Result<PointList> AxesAlong(const AxesFromGlass& axes_from_glass, PointList glass_mm,
                            const Box3& travel) {
  Vec3 near = BranchStart(travel);
  for (Vec3& point : glass_mm) {
    near = INTAGLIO_TRY(axes_from_glass.ToAxes(point, near));
    point = near;
  }
  return glass_mm;
}

}  // namespace intaglio::machine
