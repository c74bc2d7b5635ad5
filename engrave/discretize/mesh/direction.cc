#include "engrave/discretize/mesh/direction.h"

#include <Eigen/Geometry>

namespace intaglio::discretize {

Mat3 FrameOf(const Direction& direction) {
  const int w = static_cast<int>(direction.axis);
  Mat3 frame = Mat3::Zero();
  frame((w + 1) % 3, 0) = 1;
  frame((w + 2) % 3, 1) = 1;
  frame(w, 2) = 1;
  const Vec3& turn = direction.rotation_rad;
  if (turn.isZero(0)) return frame;  // exact: no rounding where nothing is turned
  return (Eigen::AngleAxisd(turn.z(), Vec3::UnitZ()) *
          Eigen::AngleAxisd(turn.y(), Vec3::UnitY()) *
          Eigen::AngleAxisd(turn.x(), Vec3::UnitX()))
             .toRotationMatrix() *
         frame;
}

}  // namespace intaglio::discretize
