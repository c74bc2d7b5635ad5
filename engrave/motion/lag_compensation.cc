#include "engrave/motion/lag_compensation.h"

#include "engrave/core/check.h"

namespace intaglio::motion {

LagCompensation::LagCompensation(double lag_s, double rate_hz, const KnotState& start)
    : lag_s_(lag_s), rate_hz_(rate_hz), from_(start) {
  Require(lag_s >= 0 && rate_hz > 0, "lag_s {} and rate_hz {} must not be negative",
          lag_s, rate_hz);
}

void LagCompensation::Append(const Segment& planned, std::vector<Segment>& out) {
  if (held_) {
    const double held_s = DurationSeconds(held_->duration_subticks, rate_hz_);
    const double next_s = DurationSeconds(planned.duration_subticks, rate_hz_);
    const Vec3 before = HermiteAcceleration(from_, *held_, held_s, held_s);
    const Vec3 behind = HermiteAcceleration(held_->end(), planned, 0, next_s);
    out.push_back(Commanded(0.5 * (before + behind)));
    from_ = held_->end();
  }
  held_ = planned;
}

void LagCompensation::Finish(std::vector<Segment>& out) {
  if (!held_) return;
  out.push_back(Commanded(Vec3::Zero()));
  from_ = held_->end();
  held_.reset();
}

Segment LagCompensation::Commanded(const Vec3& acceleration_mm_s2) const {
  Segment segment = *held_;
  segment.end_position_mm += lag_s_ * held_->end_velocity_mm_s;
  segment.end_velocity_mm_s += lag_s_ * acceleration_mm_s2;
  return segment;
}

}  // namespace intaglio::motion
