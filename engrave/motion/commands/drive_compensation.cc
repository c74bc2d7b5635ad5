#include "engrave/motion/drive_compensation.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

DriveCompensation::DriveCompensation(const drive::Drive* drive, double rate_hz,
                                     const KnotState& start)
    : rate_hz_(rate_hz), from_(start) {
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
  if (drive == nullptr) return;
  of_velocity_s_ = drive->CommandFor({0, 1, 0, 0}).position_u;
  of_acceleration_s2_ = drive->CommandFor({0, 0, 1, 0}).position_u;
  of_jerk_s3_ = drive->CommandFor({0, 0, 0, 1}).position_u;
  jerk_counts_ = of_acceleration_s2_ != 0 || of_jerk_s3_ != 0;
}

void DriveCompensation::Append(const Segment& planned, std::vector<Segment>& out) {
  if (held_) {
    const double held_s = DurationSeconds(held_->duration_subticks, rate_hz_);
    const double next_s = DurationSeconds(planned.duration_subticks, rate_hz_);
    const Vec3 before = HermiteAcceleration(from_, *held_, held_s, held_s);
    const Vec3 behind = HermiteAcceleration(held_->end(), planned, 0, next_s);
    Vec3 jerk = Vec3::Zero();
    if (jerk_counts_) {
      jerk = 0.5 * (HermiteJerk(from_, *held_, held_s) +
                    HermiteJerk(held_->end(), planned, next_s));
    }
    out.push_back(Commanded(0.5 * (before + behind), jerk));
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
  segment.end_position_mm += of_velocity_s_ * held_->end_velocity_mm_s;
  segment.end_velocity_mm_s += of_velocity_s_ * acceleration_mm_s2;
  if (!jerk_counts_) return segment;
  segment.end_position_mm +=
      of_acceleration_s2_ * acceleration_mm_s2 + of_jerk_s3_ * jerk_mm_s3;
  segment.end_velocity_mm_s += of_acceleration_s2_ * jerk_mm_s3;
  return segment;
}

}  // namespace intaglio::motion
