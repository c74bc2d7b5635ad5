#include "engrave/motion/commands/drive_compensation.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

DriveCompensation::DriveCompensation(const drive::Drive* drive, double rate_hz,
                                     const KnotState& start)
    : inverse_(drive, start.position_mm), rate_hz_(rate_hz), from_(start) {
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
}

CubicCourse DriveCompensation::CourseOf(const KnotState& from, const Segment& to) const {
  const double duration_s = DurationSeconds(to.duration_subticks, rate_hz_);
  return {from.position_mm, from.velocity_mm_s,
          HermiteAcceleration(from, to, 0, duration_s),
          HermiteJerk(from, to, duration_s)};
}

void DriveCompensation::Append(const Segment& planned, std::vector<Segment>& out) {
  if (held_) {
    const double held_s = DurationSeconds(held_->duration_subticks, rate_hz_);
    const CubicCourse before = CourseOf(from_, *held_);
    const CubicCourse behind = CourseOf(held_->end(), planned);
    Segment commanded = *held_;
    if (inverse_.continuous()) {
      const InverseDrive::Command end = inverse_.Follow(before, held_s);
      const InverseDrive::Command begin = inverse_.AtBegin(behind);
      commanded.end_position_mm = end.position_mm;
      commanded.end_velocity_mm_s = 0.5 * (end.velocity_mm_s + begin.velocity_mm_s);
    } else {
      const InverseDrive::Command mean = inverse_.WithoutTransients(
          {held_->end_position_mm, held_->end_velocity_mm_s,
           0.5 * (HermiteAcceleration(from_, *held_, held_s, held_s) +
                  behind.acceleration_mm_s2),
           0.5 * (before.jerk_mm_s3 + behind.jerk_mm_s3)});
      commanded.end_position_mm = mean.position_mm;
      commanded.end_velocity_mm_s = mean.velocity_mm_s;
    }
    out.push_back(commanded);
    from_ = held_->end();
  }
  held_ = planned;
}

void DriveCompensation::Finish(std::vector<Segment>& out) {
  if (!held_) return;
  const InverseDrive::Command end =
      inverse_.WithoutTransients({held_->end_position_mm, held_->end_velocity_mm_s});
  held_->end_position_mm = end.position_mm;
  held_->end_velocity_mm_s = end.velocity_mm_s;
  out.push_back(*held_);
  from_ = held_->end();
  held_.reset();
}

}  // namespace intaglio::motion
