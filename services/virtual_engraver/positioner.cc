#include "services/virtual_engraver/positioner.h"

#include <Eigen/Geometry>
#include <algorithm>

// Each carriage is a rigid motion of the laboratory: the head's takes the beam along, the
// block's takes the block along. The focus in the frame of the block is the inverse of
// the block's motion, applied to the focus in the laboratory.

namespace intaglio::virtual_engraver {
namespace {

using Motion = Eigen::Isometry3d;

Vec3 Travelled(const Guide& guide, int axis, double coordinate) {
  const double way_mm = guide.travel_ratio * coordinate;
  const Vec3 along =
      Eigen::AngleAxisd(guide.turn_rad, Vec3::UnitZ()) * Vec3(Vec3::Unit(axis));
  return (guide.backwards ? -way_mm : way_mm) * along;
}

Motion Turn(double angle_rad, const Vec3& pivot_mm) {
  return Eigen::Translation3d(pivot_mm) * Eigen::AngleAxisd(angle_rad, Vec3::UnitZ()) *
         Eigen::Translation3d(-pivot_mm);
}

Vec2 OfField(const PositionerOptions& positioner, const Vec3& axes) {
  const Vec2 in_field_mm = axes.head<2>() + positioner.deviations.At(axes.head<2>());
  const Vec2 commanded_mm = (Travelled(positioner.guides[0], 0, in_field_mm.x()) +
                             Travelled(positioner.guides[1], 1, in_field_mm.y()))
                                .head<2>();
  const double share = 1e-4 * commanded_mm.squaredNorm();
  return (1 + positioner.distortion_ratio * share) * commanded_mm;
}

}  // namespace

Vec2 FieldDeviations::At(const Vec2& commanded_mm) const {
  if (nodes < 2) return Vec2::Zero();
  const Vec2 in_nodes = (commanded_mm / pitch_mm + Vec2::Constant(0.5 * (nodes - 1)))
                            .cwiseMax(0)
                            .cwiseMin(nodes - 1);
  const Vec2 corner = in_nodes.array().floor().min(nodes - 2.0);
  const Vec2 share = in_nodes - corner;
  const auto node = [&](int right, int up) {
    const int i = static_cast<int>(corner.x()) + right;
    const int j = static_cast<int>(corner.y()) + up;
    const double weight =
        (right == 1 ? share.x() : 1 - share.x()) * (up == 1 ? share.y() : 1 - share.y());
    return Vec2(weight * values_mm[static_cast<std::size_t>(j * nodes + i)]);
  };
  return node(0, 0) + node(1, 0) + node(0, 1) + node(1, 1);
}

Vec2 BeamSlopes(const PositionerOptions& positioner, const Vec3& axes) {
  if (!positioner.has_mirrors) return Vec2::Zero();
  return OfField(positioner, axes).cwiseQuotient(positioner.pupil_mm);
}

Vec3 FocusAt(const PositionerOptions& positioner, const Vec3& axes,
             const Vec2& block_mm) {
  Vec3 focus_mm = Vec3::Zero();
  Motion of_block = Motion::Identity();
  const auto guide = [&](int axis) {
    const Guide& g = positioner.guides[static_cast<std::size_t>(axis)];
    const Vec3 travelled_mm = Travelled(g, axis, axes[axis]);
    if (g.carries_block) {
      of_block.pretranslate(travelled_mm);
    } else {
      focus_mm += travelled_mm;
    }
  };
  if (positioner.has_arm) {
    const Vec3 pivot_mm(0, positioner.pivot_distance_mm, 0);
    const Vec3 at_zero_mm = pivot_mm - Vec3(0, positioner.arm_length_mm, 0);
    focus_mm = Turn(axes[0], pivot_mm) * at_zero_mm;
    of_block = Turn(axes[1], Vec3::Zero());
  } else if (positioner.has_mirrors) {
    focus_mm.head<2>() = OfField(positioner, axes);
    of_block.pretranslate(Travelled(positioner.block_guides[0], 0, block_mm.x()));
    of_block.pretranslate(Travelled(positioner.block_guides[1], 1, block_mm.y()));
  } else {
    guide(0);
    guide(1);
  }
  guide(2);
  return of_block.inverse(Eigen::Isometry) * focus_mm;
}

Vec3 FocusPerAxisUnitMm(const PositionerOptions& positioner, const Box3& block_mm) {
  if (!positioner.has_arm) return Vec3::Ones();
  double farthest_mm = 0;
  for (const double x_mm : {block_mm.min_mm.x(), block_mm.max_mm.x()}) {
    for (const double y_mm : {block_mm.min_mm.y(), block_mm.max_mm.y()}) {
      farthest_mm = std::max(farthest_mm, Vec2(x_mm, y_mm).norm());
    }
  }
  return {positioner.arm_length_mm, farthest_mm, 1};
}

}  // namespace intaglio::virtual_engraver
