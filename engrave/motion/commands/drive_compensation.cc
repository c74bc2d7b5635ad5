#include "engrave/motion/commands/drive_compensation.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

namespace {

// What is left of a transient that is no longer followed: 1 um, or after 200 ticks.
constexpr double kNearMm = 0.001;
constexpr std::uint64_t kMaxTailTicks = 200;

bool IsNear(const Vec3& a, const Vec3& b) {
  return (a - b).cwiseAbs().maxCoeff() < kNearMm;
}

}  // namespace

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
  const Vec3 rest_mm = held_->end_position_mm;
  Segment last = *held_;
  if (inverse_.continuous()) last = FollowTail(last, out);
  last.end_position_mm = rest_mm;
  last.end_velocity_mm_s = Vec3::Zero();
  out.push_back(last);
  from_ = held_->end();
  held_.reset();
}

Segment DriveCompensation::FollowTail(Segment last, std::vector<Segment>& out) {
  const CubicCourse rest{last.end_position_mm};
  const bool program_end = last.program_end;
  InverseDrive::Command end = inverse_.Follow(
      CourseOf(from_, last), DurationSeconds(last.duration_subticks, rate_hz_));
  while (!IsNear(end.position_mm, rest.position_mm) && tail_ticks_ < kMaxTailTicks) {
    last.end_position_mm = end.position_mm;
    last.end_velocity_mm_s =
        0.5 * (end.velocity_mm_s + inverse_.AtBegin(rest).velocity_mm_s);
    last.program_end = false;
    out.push_back(last);
    end = inverse_.Follow(rest, 1 / rate_hz_);
    last = {};
    last.duration_subticks = kSubticksPerTick;
    ++tail_ticks_;
  }
  last.program_end = program_end;
  return last;
}

}  // namespace intaglio::motion
