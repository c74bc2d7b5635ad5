#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

// In a face across x the front rises at an angle of atan(1.05) = 46 degrees to z, in one
// across y at 42 degrees, in one across z at 49 degrees to x: about 15 degrees from the
// nearest row of a hexagonal packing. In upright faces turned by 45 degrees it rises at
// 54 and 6 degrees.
Vec3 ObliqueRise() { return Vec3(0.9, 1.05, 1).normalized(); }

HeightRange HeightsOf(const Box3& bounds, const Vec3& rise) {
  HeightRange heights{std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
  if (bounds.empty()) return heights;
  heights = {0, 0};
  for (int i = 0; i < 3; ++i) {
    const double a = rise[i] * bounds.min_mm[i], b = rise[i] * bounds.max_mm[i];
    heights.low_mm += std::min(a, b);
    heights.high_mm += std::max(a, b);
  }
  return heights;
}

}  // namespace intaglio::discretize
