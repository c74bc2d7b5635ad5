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

DriveCompensation::DriveCompensation(const drive::AxisDrives& drives, double rate_hz,
                                     const KnotState& start)
    : inverses_{InverseDrive(drives[0].get(), start.position_mm[0]),
                InverseDrive(drives[1].get(), start.position_mm[1]),
                InverseDrive(drives[2].get(), start.position_mm[2])},
      rate_hz_(rate_hz),
      from_(start) {
  Require(rate_hz > 0, "rate_hz {} must be positive", rate_hz);
}

bool DriveCompensation::continuous() const {
  return inverses_[0].continuous() || inverses_[1].continuous() ||
         inverses_[2].continuous();
}

drive::Cubic DriveCompensation::CourseOf(const KnotState& from, const Segment& to,
                                         int axis) const {
  const double duration_s = DurationSeconds(to.duration_subticks, rate_hz_);
  return {from.position_mm[axis], from.velocity_mm_s[axis],
          HermiteAcceleration(from, to, 0, duration_s)[axis],
          HermiteJerk(from, to, duration_s)[axis]};
}

InverseDrive::Command DriveCompensation::AtKnot(int axis, const Segment& before,
                                                const Segment& behind) {
  InverseDrive& inverse = inverses_[static_cast<std::size_t>(axis)];
  const double before_s = DurationSeconds(before.duration_subticks, rate_hz_);
  const drive::Cubic of_before = CourseOf(from_, before, axis);
  const drive::Cubic of_behind = CourseOf(before.end(), behind, axis);
  if (inverse.continuous()) {
    const InverseDrive::Command end = inverse.Follow(of_before, before_s);
    const InverseDrive::Command begin = inverse.AtBegin(of_behind);
    return {end.position, 0.5 * (end.velocity + begin.velocity)};
  }
  const double acceleration =
      HermiteAcceleration(from_, before, before_s, before_s)[axis];
  return inverse.WithoutTransients({before.end_position_mm[axis],
                                    before.end_velocity_mm_s[axis],
                                    0.5 * (acceleration + of_behind.acceleration_u_s2),
                                    0.5 * (of_before.jerk_u_s3 + of_behind.jerk_u_s3)});
}

void DriveCompensation::Append(const Segment& planned, std::vector<Segment>& out) {
  if (held_) {
    Segment commanded = *held_;
    for (int axis = 0; axis < 3; ++axis) {
      const InverseDrive::Command command = AtKnot(axis, *held_, planned);
      commanded.end_position_mm[axis] = command.position;
      commanded.end_velocity_mm_s[axis] = command.velocity;
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
  if (continuous()) last = FollowTail(last, out);
  last.end_position_mm = rest_mm;
  last.end_velocity_mm_s = Vec3::Zero();
  out.push_back(last);
  from_ = held_->end();
  held_.reset();
}

// An axis without transients rests at its end.
Segment DriveCompensation::FollowTail(Segment last, std::vector<Segment>& out) {
  const KnotState rest{last.end_position_mm, Vec3::Zero()};
  const bool program_end = last.program_end;
  KnotState end = rest;
  const auto follow = [&](const KnotState& from, const Segment& to) {
    for (int axis = 0; axis < 3; ++axis) {
      InverseDrive& inverse = inverses_[static_cast<std::size_t>(axis)];
      if (!inverse.continuous()) continue;
      const InverseDrive::Command command = inverse.Follow(
          CourseOf(from, to, axis), DurationSeconds(to.duration_subticks, rate_hz_));
      end.position_mm[axis] = command.position;
      end.velocity_mm_s[axis] =
          0.5 * (command.velocity + inverse.AtBegin({rest.position_mm[axis]}).velocity);
    }
  };
  follow(from_, last);
  while (!IsNear(end.position_mm, rest.position_mm) && tail_ticks_ < kMaxTailTicks) {
    last.end_position_mm = end.position_mm;
    last.end_velocity_mm_s = end.velocity_mm_s;
    last.program_end = false;
    out.push_back(last);
    last = {};
    last.duration_subticks = kSubticksPerTick;
    last.end_position_mm = rest.position_mm;
    follow(rest, last);
    ++tail_ticks_;
  }
  last.program_end = program_end;
  return last;
}

}  // namespace intaglio::motion
