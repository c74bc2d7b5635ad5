#include "tests/integration/course/flashes.h"

#include <fstream>
#include <sstream>
#include <string>

namespace intaglio::testing {

FlashRecord ReadFlashes(const std::filesystem::path& file) {
  FlashRecord flashes;
  std::ifstream record(file);
  for (std::string line; std::getline(record, line);) {
    std::istringstream in(line);
    std::string kind;
    Vec3 at;
    if (in >> kind && kind == "rest") in >> flashes.lit_at_rest_us;
    if (kind == "flash" && in >> at.x() >> at.y() >> at.z())
      flashes.began_mm.push_back(at);
  }
  return flashes;
}

HeightFit FitHeight(const PointList& points_mm, const PointList& flashes_mm) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Vec3& flash : flashes_mm) {
    const Vec3* only = nullptr;
    int near = 0;
    for (const Vec3& point : points_mm) {
      if ((point - flash).head<2>().norm() > 0.03) continue;
      ++near;
      only = &point;
    }
    if (near != 1) continue;
    n += 1, sx += only->z(), sy += flash.z();
    sxx += only->z() * only->z(), sxy += only->z() * flash.z();
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, (sy - slope * sx) / n};
}

}  // namespace intaglio::testing
