#include "engrave/sort/near/way_speeds.h"

#include <cmath>

namespace intaglio::sort {

using motion::SpeedEnds;

bool SpeedBox::IsNear(const SpeedBox& other) const {
  constexpr double kNear = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const SpeedEnds apart = axis[i] - other.axis[i];
    if (!(std::abs(apart[0]) <= kNear && std::abs(apart[1]) <= kNear)) return false;
  }
  return true;
}

bool SpeedBox::Meets(const SpeedBox& other) const {
  for (int i = 0; i < 3; ++i) {
    if (motion::IsEmpty(motion::Intersection(axis[i], other.axis[i]))) return false;
  }
  return true;
}

/// {lo, -hi} of the opposite velocities is {-hi, lo}.
SpeedBox SpeedBox::Reversed() const {
  SpeedBox reversed;
  for (int i = 0; i < 3; ++i) reversed.axis[i] = SpeedEnds{axis[i][1], axis[i][0]};
  return reversed;
}

WaySpeeds::WaySpeeds(const TickCost& cost) {
  const Vec3 top = cost.TopSpeeds();
  for (int i = 0; i < 3; ++i) {
    limits_[i].max_speed_mm_s = top[i];
    limits_[i].max_acceleration_mm_s2 = 1;
    any_.axis[i] = SpeedEnds{-top[i], -top[i]};
  }
}

bool WaySpeeds::Pass(const SpeedBox& from, const TimedMove& move, SpeedBox& to) const {
  const float distance[] = {move.step.x, move.step.y, move.step.z};
  for (int i = 0; i < 3; ++i) {
    const motion::AxisReach reach(distance[i], move.ticks, limits_[i]);
    const SpeedEnds start = motion::Intersection(from.axis[i], reach.Usable());
    if (motion::IsEmpty(start)) return false;
    to.axis[i] = reach.After(start);
  }
  return true;
}

}  // namespace intaglio::sort
