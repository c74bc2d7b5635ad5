#include "engrave/motion/commands/error_prediction.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

ErrorPrediction::ErrorPrediction(const drive::AxisDrives& drives, double rate_hz,
                                 const Vec3& start)
    : drives_(drives), rate_hz_(rate_hz), from_{start, Vec3::Zero()} {
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const double at = start[static_cast<int>(i)];
    states_[i] = drives[i] ? drives[i]->SettledState({at}) : drive::AxisState{at};
  }
}

void ErrorPrediction::Append(const Segment& commanded, std::vector<PredictedPlace>& out) {
  const double duration_s = DurationSeconds(commanded.duration_subticks, rate_hz_);
  const Vec3 acceleration = HermiteAcceleration(from_, commanded, 0, duration_s);
  const Vec3 jerk = HermiteJerk(from_, commanded, duration_s);
  PredictedPlace place;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!drives_[i]) {
      place.axes[axis] = commanded.end_position_mm[axis];
      continue;
    }
    states_[i] = drives_[i]->Follow(states_[i],
                                    {from_.position_mm[axis], from_.velocity_mm_s[axis],
                                     acceleration[axis], jerk[axis]},
                                    duration_s);
    place.axes[axis] = states_[i].position_u;
  }
  from_ = commanded.end();
  if (commanded.point < 0) return;
  place.point = commanded.point;
  out.push_back(place);
}

}  // namespace intaglio::motion
