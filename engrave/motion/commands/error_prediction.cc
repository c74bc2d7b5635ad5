#include "engrave/motion/commands/error_prediction.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

ErrorPrediction::ErrorPrediction(const drive::Drive* drive, double rate_hz,
                                 const Vec3& start)
    : drive_(drive), rate_hz_(rate_hz), from_{start, Vec3::Zero()} {
  Require(drive != nullptr, "a prediction without a drive");
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
  for (int axis = 0; axis < 3; ++axis)
    states_[static_cast<std::size_t>(axis)] = drive->SettledState({start[axis], 0, 0, 0});
}

void ErrorPrediction::Append(const Segment& commanded, std::vector<PredictedPlace>& out) {
  const double duration_s = DurationSeconds(commanded.duration_subticks, rate_hz_);
  const Vec3 acceleration = HermiteAcceleration(from_, commanded, 0, duration_s);
  const Vec3 jerk = HermiteJerk(from_, commanded, duration_s);
  PredictedPlace place;
  for (int axis = 0; axis < 3; ++axis) {
    drive::AxisState& state = states_[static_cast<std::size_t>(axis)];
    state = drive_->Follow(state,
                           {from_.position_mm[axis], from_.velocity_mm_s[axis],
                            acceleration[axis], jerk[axis]},
                           duration_s);
    place.axes[axis] = state.position_u;
  }
  from_ = commanded.end();
  if (commanded.point < 0) return;
  place.point = commanded.point;
  out.push_back(place);
}

}  // namespace intaglio::motion
