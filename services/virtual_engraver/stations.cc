#include "services/virtual_engraver/stations.h"

#include <Eigen/Geometry>

namespace intaglio::virtual_engraver {
namespace {

double DistanceMm(const Vec3& position_mm, const Vec3& size_mm) {
  return (position_mm - position_mm.cwiseMax(Vec3::Zero()).cwiseMin(size_mm)).norm();
}

}  // namespace

StationFocus TraceFocus(const Vec3& stage_mm, const BlockInMachine& block,
                        std::span<const StationInMachine> further, const Vec2& slopes) {
  StationFocus found{1, TraceFocus(stage_mm, block, slopes)};
  std::uint8_t station = 1;
  for (const StationInMachine& other : further) {
    ++station;
    const Vec3 seen_mm =
        Eigen::AngleAxisd(-other.turn_rad, Vec3::UnitZ()) * stage_mm - other.offset_mm;
    const Focus focus =
        TraceFocus(seen_mm, block, Eigen::Rotation2Dd(-other.turn_rad) * slopes);
    if (DistanceMm(focus.position_mm, block.size_mm) <
        DistanceMm(found.focus.position_mm, block.size_mm)) {
      found = {station, focus};
    }
  }
  return found;
}

}  // namespace intaglio::virtual_engraver
