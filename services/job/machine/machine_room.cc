#include "services/job/machine/machine_room.h"

#include <algorithm>
#include <cmath>

#include "services/job/fields/shapes.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

/// Along one axis: a head moves over a block at rest, or a block under a beam at zero.
double RoomAlong(const LinearAxis& axis, double travel_min_mm, double travel_max_mm,
                 double origin_mm, double block_mm) {
  double low_mm = origin_mm, high_mm = origin_mm + block_mm;
  if (axis.moves() == AXIS_MOVES_TABLE)
    return high_mm - low_mm + (travel_max_mm - travel_min_mm);
  const double sign = axis.reversed() ? -1 : 1;
  for (const double end_mm : {travel_min_mm, travel_max_mm}) {
    low_mm = std::min(low_mm, sign * end_mm);
    high_mm = std::max(high_mm, sign * end_mm);
  }
  return high_mm - low_mm;
}

/// The block turns about the origin, the arm about a point on +y.
Vec2 RoomOfArmAndTable(const MachineSpec& machine, const Vec3& block_mm) {
  const Vec3 corner_mm = Vec3Of(machine.block_origin_mm());
  double radius_mm = machine.loading().table_radius_mm();
  for (const double x : {0.0, block_mm.x()}) {
    for (const double y : {0.0, block_mm.y()})
      radius_mm = std::max(radius_mm, std::hypot(corner_mm.x() + x, corner_mm.y() + y));
  }
  const PolarKinematics& polar = machine.polar();
  Vec2 low_mm(-radius_mm, -radius_mm);
  Vec2 high_mm(radius_mm, std::max(radius_mm, polar.axis_distance_mm()));
  const auto kinematics = KinematicsOf(machine);
  constexpr int kSteps = 360;
  const RotaryAxis& arm = polar.arm();
  for (int i = 0; i <= kSteps; ++i) {
    const double angle =
        arm.travel_min_rad() + (arm.travel_max_rad() - arm.travel_min_rad()) * i / kSteps;
    const Vec2 beam_mm = kinematics->ToPlace({angle, 0, 0}).head<2>();
    low_mm = low_mm.cwiseMin(beam_mm);
    high_mm = high_mm.cwiseMax(beam_mm);
  }
  return high_mm - low_mm;
}

}  // namespace

Vec2 RoomOf(const MachineSpec& machine, const Vec3& block_mm) {
  if (machine.has_polar()) return RoomOfArmAndTable(machine, block_mm);
  const Vector3& origin = machine.block_origin_mm();
  return {RoomAlong(machine.cartesian().x(), machine.x().travel_min_mm(),
                    machine.x().travel_max_mm(), origin.x(), block_mm.x()),
          RoomAlong(machine.cartesian().y(), machine.y().travel_min_mm(),
                    machine.y().travel_max_mm(), origin.y(), block_mm.y())};
}

}  // namespace intaglio
