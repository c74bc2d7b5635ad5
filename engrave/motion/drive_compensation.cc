#include "engrave/motion/drive_compensation.h"

#include <utility>

#include "engrave/core/check.h"

namespace intaglio::motion {

DriveCompensation::DriveCompensation(std::shared_ptr<const drive::Drive> drive,
                                     double rate_hz, const KnotState& start)
    : drive_(std::move(drive)), rate_hz_(rate_hz), from_(start) {
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
}

void DriveCompensation::Append(const Segment& planned, std::vector<Segment>& out) {
  if (held_) {
    const double held_s = DurationSeconds(held_->duration_subticks, rate_hz_);
    const double next_s = DurationSeconds(planned.duration_subticks, rate_hz_);
    const Vec3 before = HermiteAcceleration(from_, *held_, held_s, held_s);
    const Vec3 behind = HermiteAcceleration(held_->end(), planned, 0, next_s);
    const Vec3 jerk_before = HermiteJerk(from_, *held_, held_s);
    const Vec3 jerk_behind = HermiteJerk(held_->end(), planned, next_s);
    out.push_back(Commanded(0.5 * (before + behind), 0.5 * (jerk_before + jerk_behind)));
    from_ = held_->end();
  }
  held_ = planned;
}

void DriveCompensation::Finish(std::vector<Segment>& out) {
  if (!held_) return;
  out.push_back(Commanded(Vec3::Zero(), Vec3::Zero()));
  from_ = held_->end();
  held_.reset();
}

Segment DriveCompensation::Commanded(const Vec3& acceleration_mm_s2,
                                     const Vec3& jerk_mm_s3) const {
  Segment segment = *held_;
  if (!drive_) return segment;
  for (int axis = 0; axis < 3; ++axis) {
    const drive::Cubic command =
        drive_->CommandFor({held_->end_position_mm[axis], held_->end_velocity_mm_s[axis],
                            acceleration_mm_s2[axis], jerk_mm_s3[axis]});
    segment.end_position_mm[axis] = command.position_u;
    segment.end_velocity_mm_s[axis] = command.velocity_u_s;
  }
  return segment;
}

}  // namespace intaglio::motion
