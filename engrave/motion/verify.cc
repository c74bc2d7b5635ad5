#include "engrave/motion/verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"

// A cubic with end positions P0, P1, end velocities v0, v1 and duration d has the
// Bezier points B0 = P0, B1 = P0 + v0 d / 3, B2 = P1 - v1 d / 3, B3 = P1. Its velocity
// is the quadratic with Bezier points 3 (B[i+1] - B[i]) / d, its acceleration the line
// between 2 (V[i+1] - V[i]) / d. The speed of an axis is extreme at the ends or where
// its acceleration changes sign, u = a0 / (a0 - a1).
// Its position is extreme where its velocity is 0, the length of the velocity where
// v . a = 0: a cubic, whose roots are bracketed by the samples and bisected.
// The integral of |a|^2 over a line from a0 to a1 is d (a0.a0 + a0.a1 + a1.a1) / 3.

namespace intaglio::motion {
namespace {

constexpr std::size_t kMaxSentences = 20;

struct Bezier {
  std::array<Vec3, 4> position;
  std::array<Vec3, 3> velocity;
  std::array<Vec3, 2> acceleration;
};

Bezier BezierOf(const KnotState& from, const Segment& to, double d) {
  Bezier curve;
  curve.position = {from.position_mm, from.position_mm + from.velocity_mm_s * (d / 3.0),
                    to.end_position_mm - to.end_velocity_mm_s * (d / 3.0),
                    to.end_position_mm};
  // The ends are the given velocities, not differences of rounded positions.
  curve.velocity = {from.velocity_mm_s, 3.0 / d * (curve.position[2] - curve.position[1]),
                    to.end_velocity_mm_s};
  for (int i = 0; i < 2; ++i) {
    curve.acceleration[i] = 2.0 / d * (curve.velocity[i + 1] - curve.velocity[i]);
  }
  return curve;
}

/// de Casteljau: repeated interpolation between neighbouring points.
template <std::size_t N>
Vec3 PointOf(std::array<Vec3, N> control, double u) {
  for (std::size_t left = N - 1; left > 0; --left) {
    for (std::size_t i = 0; i < left; ++i) {
      control[i] = (1.0 - u) * control[i] + u * control[i + 1];
    }
  }
  return control[0];
}

/// The last bit of the coordinates of a segment; of a millimetre at least, since near 0
/// they are still sums of parts of a step.
double BitMm(const KnotState& from, const Segment& to) {
  return std::numeric_limits<double>::epsilon() *
         std::max({1.0, from.position_mm.cwiseAbs().maxCoeff(),
                   to.end_position_mm.cwiseAbs().maxCoeff()});
}

/// Adds where an axis turns back, by the roots of its velocity in powers of u.
void ExtendToTurns(const Bezier& curve, Box3& extent_mm) {
  for (int axis = 0; axis < 3; ++axis) {
    const double c = curve.velocity[0][axis];
    const double b = 2 * (curve.velocity[1][axis] - c);
    const double a = curve.velocity[2][axis] - c - b;
    const double root = std::sqrt(std::max(b * b - 4 * a * c, 0.0));
    const double q = -0.5 * (b + std::copysign(root, b));
    for (const double u : {q / a, c / q}) {
      if (u > 0 && u < 1) extent_mm.Extend(PointOf(curve.position, u));
    }
  }
}

/// The longest velocity between u = lo, where it grows, and hi, where it shrinks.
double LongestVelocity(const Bezier& curve, double lo, double hi) {
  for (int halving = 0; halving < 40; ++halving) {
    const double u = 0.5 * (lo + hi);
    const bool grows = PointOf(curve.velocity, u).dot(PointOf(curve.acceleration, u)) > 0;
    (grows ? lo : hi) = u;
  }
  return PointOf(curve.velocity, lo).norm();
}

}  // namespace

MotionVerifier::MotionVerifier(const KnotState& start, const PointList& planned_mm,
                               const Limits& limits, double rate_hz,
                               const VerifyOptions& options)
    : planned_mm_(planned_mm),
      limits_(limits),
      rate_hz_(rate_hz),
      options_(options),
      from_(start),
      seen_(planned_mm.size(), false) {
  Require(rate_hz > 0.0, "rate_hz must be positive, is {}", rate_hz);
  Require(options.samples >= 0, "samples must not be negative, are {}", options.samples);
  if (!start.velocity_mm_s.isZero(0.0)) Violate("the motion does not start at rest");
}

void MotionVerifier::Append(const Segment& segment) {
  if (program_ended_) {
    Violate(fmt::format("segment {} ends the program but others follow", segment_ - 1));
  }
  const bool finite =
      segment.end_position_mm.allFinite() && segment.end_velocity_mm_s.allFinite();
  if (segment.duration_subticks == 0 || !finite) {
    Violate(fmt::format("segment {} has no duration or is not finite", segment_));
  } else {
    subticks_ += segment.duration_subticks;
    CheckCurve(segment);
    CheckPoint(segment);
    if (segment.program_end && !segment.end_velocity_mm_s.isZero(0.0)) {
      Violate(fmt::format("segment {} ends the program in motion", segment_));
    }
  }
  program_ended_ = segment.program_end;
  from_ = segment.end();
  ++segment_;
}

MotionReport MotionVerifier::Finish() {
  if (!from_.velocity_mm_s.isZero(0.0)) Violate("the motion does not end at rest");
  for (int axis = 0; axis < 3; ++axis) CheckJump(axis, 0.0, 0.0);
  variation_ += acceleration_.norm();
  const double total_s = DurationSeconds(subticks_, rate_hz_);
  if (total_s > 0.0) {
    report_.rms_acceleration_mm_s2 = std::sqrt(square_ / total_s);
    report_.mean_jerk_mm_s3 = variation_ / total_s;
  }
  report_.ticks = (subticks_ + kSubticksPerTick - 1) / kSubticksPerTick;
  const auto missing = std::count(seen_.begin(), seen_.end(), false);
  if (options_.all_points && missing > 0) {
    Violate(fmt::format("{} of {} {} never reached", missing,
                        Counted(seen_.size(), "point"),
                        IsOrAre(static_cast<std::uint64_t>(missing))));
  }
  return std::move(report_);
}

void MotionVerifier::Violate(std::string sentence) {
  ++report_.violation_count;
  if (report_.violations.size() < kMaxSentences) {
    report_.violations.push_back(std::move(sentence));
  }
}

void MotionVerifier::CheckCurve(const Segment& to) {
  const double d = DurationSeconds(to.duration_subticks, rate_hz_);
  const Bezier curve = BezierOf(from_, to, d);
  const auto& [a0, a1] = curve.acceleration;
  Vec3 speed = curve.velocity[0].cwiseAbs().cwiseMax(curve.velocity[2].cwiseAbs());
  for (int axis = 0; axis < 3; ++axis) {
    if (a0[axis] * a1[axis] >= 0.0) continue;
    const double u = a0[axis] / (a0[axis] - a1[axis]);
    speed[axis] = std::max(speed[axis], std::abs(PointOf(curve.velocity, u)[axis]));
  }
  Vec3 acceleration = a0.cwiseAbs().cwiseMax(a1.cwiseAbs());
  double length_mm_s = std::max(curve.velocity[0].norm(), curve.velocity[2].norm());
  bool grew = curve.velocity[0].dot(a0) > 0;
  Box3 extent_mm{from_.position_mm, from_.position_mm};
  ExtendToTurns(curve, extent_mm);
  Vec3 before_mm = from_.position_mm;
  for (int k = 1; k <= options_.samples + 1; ++k) {
    const double u = static_cast<double>(k) / (options_.samples + 1);
    const Vec3 at_mm = PointOf(curve.position, u);
    const Vec3 v = PointOf(curve.velocity, u), a = PointOf(curve.acceleration, u);
    report_.path_mm += (at_mm - before_mm).norm();
    extent_mm.Extend(at_mm);
    speed = speed.cwiseMax(v.cwiseAbs());
    acceleration = acceleration.cwiseMax(a.cwiseAbs());
    const bool grows = v.dot(a) > 0;
    if (grew && !grows) {
      const double lo = static_cast<double>(k - 1) / (options_.samples + 1);
      length_mm_s = std::max(length_mm_s, LongestVelocity(curve, lo, u));
    }
    grew = grows;
    before_mm = at_mm;
  }
  CheckAxes(to, d, speed, acceleration);
  CheckLengths(to, d, length_mm_s, std::max(a0.norm(), a1.norm()));
  CheckJerk(to, d, a0, a1);
  CheckTravel(extent_mm);
  square_ += d / 3.0 * (a0.dot(a0) + a0.dot(a1) + a1.dot(a1));
  variation_ += (a0 - acceleration_).norm() + (a1 - a0).norm();
  acceleration_ = a1;
  acceleration_bits_ = 12.0 * BitMm(from_, to) / (d * d);
}

// A coordinate is exact to its last bit only; over a duration d that makes up to 3 bits /
// d of speed, 12 bits / d^2 of acceleration and 24 bits / d^3 of jerk (the Hermite
// weights).
void MotionVerifier::CheckAxes(const Segment& to, double d, const Vec3& speed,
                               const Vec3& acceleration) {
  const double bit_mm = BitMm(from_, to);
  const double allowed = 1.0 + options_.limit_slack_ratio;
  for (int axis = 0; axis < 3; ++axis) {
    const double v_max = limits_.max_speed_mm_s[axis];
    const double a_max = limits_.max_acceleration_mm_s2[axis];
    if (speed[axis] > v_max * allowed + 3.0 * bit_mm / d) {
      Violate(fmt::format("segment {}: axis {} reaches {} mm/s, limit {}", segment_, axis,
                          speed[axis], v_max));
    }
    if (acceleration[axis] > a_max * allowed + 12.0 * bit_mm / (d * d)) {
      Violate(fmt::format("segment {}: axis {} reaches {} mm/s^2, limit {}", segment_,
                          axis, acceleration[axis], a_max));
    }
  }
  report_.max_speed_mm_s = report_.max_speed_mm_s.cwiseMax(speed);
  report_.max_acceleration_mm_s2 = report_.max_acceleration_mm_s2.cwiseMax(acceleration);
}

void MotionVerifier::CheckLengths(const Segment& to, double d, double speed,
                                  double acceleration) {
  const double bit_mm = 2.0 * BitMm(from_, to);  // of three axes together
  const double allowed = 1.0 + options_.limit_slack_ratio;
  if (speed > limits_.max_speed_norm_mm_s * allowed + 3.0 * bit_mm / d) {
    Violate(fmt::format("segment {}: the length of the velocity is {} mm/s, limit {}",
                        segment_, speed, limits_.max_speed_norm_mm_s));
  }
  if (acceleration >
      limits_.max_acceleration_norm_mm_s2 * allowed + 12.0 * bit_mm / (d * d)) {
    Violate(
        fmt::format("segment {}: the length of the acceleration is {} mm/s^2, limit {}",
                    segment_, acceleration, limits_.max_acceleration_norm_mm_s2));
  }
  report_.peak_speed_mm_s = std::max(report_.peak_speed_mm_s, speed);
  report_.peak_acceleration_mm_s2 =
      std::max(report_.peak_acceleration_mm_s2, acceleration);
}

void MotionVerifier::CheckJerk(const Segment& to, double d, const Vec3& a0,
                               const Vec3& a1) {
  const Vec3 jerk = (a1 - a0).cwiseAbs() / d;
  const double bits = 12.0 * BitMm(from_, to) / (d * d);
  for (int axis = 0; axis < 3; ++axis) {
    const double largest = limits_.max_jerk_mm_s3[axis];
    if (jerk[axis] > largest * (1.0 + options_.limit_slack_ratio) + 2.0 * bits / d) {
      Violate(fmt::format("segment {}: axis {} reaches {} mm/s^3, limit {}", segment_,
                          axis, jerk[axis], largest));
    }
    CheckJump(axis, a0[axis], bits);
  }
  report_.max_jerk_mm_s3 = report_.max_jerk_mm_s3.cwiseMax(jerk);
}

void MotionVerifier::CheckJump(int axis, double to_mm_s2, double bits) {
  if (limits_.max_jerk_mm_s3[axis] == kUnlimited) return;
  const double jump = std::abs(to_mm_s2 - acceleration_[axis]);
  // Several roundings lie between the two sides.
  if (jump <= limits_.max_acceleration_mm_s2[axis] * options_.limit_slack_ratio +
                  16.0 * (bits + acceleration_bits_)) {
    return;
  }
  Violate(fmt::format("segment {}: the acceleration of axis {} jumps by {} mm/s^2",
                      segment_, axis, jump));
}

void MotionVerifier::CheckTravel(const Box3& extent_mm) {
  constexpr double kTravelSlackMm = 1e-9;
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = extent_mm.min_mm[axis], hi = extent_mm.max_mm[axis];
    if (lo >= limits_.travel_mm.min_mm[axis] - kTravelSlackMm &&
        hi <= limits_.travel_mm.max_mm[axis] + kTravelSlackMm) {
      continue;
    }
    Violate(fmt::format("segment {}: axis {} goes from {} to {} mm, travel {} to {}",
                        segment_, axis, lo, hi, limits_.travel_mm.min_mm[axis],
                        limits_.travel_mm.max_mm[axis]));
  }
  report_.extent_mm.Extend(extent_mm.min_mm);
  report_.extent_mm.Extend(extent_mm.max_mm);
}

void MotionVerifier::CheckPoint(const Segment& to) {
  if (to.pulse && subticks_ % kSubticksPerTick != 0) {
    Violate(fmt::format("segment {}: its pulse is not at a whole tick", segment_));
  }
  if (to.point < 0) return;
  const auto point = static_cast<std::size_t>(to.point);
  if (point >= planned_mm_.size()) {
    Violate(fmt::format("segment {}: there is no point {}", segment_, point));
    return;
  }
  if (seen_[point]) Violate(fmt::format("segment {}: point {} again", segment_, point));
  seen_[point] = true;
  const double off_mm = (to.end_position_mm - planned_mm_[point]).norm();
  const bool on_tick = subticks_ % kSubticksPerTick == 0;
  report_.max_point_move_mm = std::max(report_.max_point_move_mm, off_mm);
  const bool in_place = off_mm <= options_.position_tolerance_mm;
  if (!on_tick) Violate(fmt::format("point {} is not at a whole tick", point));
  if (!in_place) {
    Violate(fmt::format("point {} is {} mm from its planned position", point, off_mm));
  }
  report_.points += on_tick && in_place ? 1 : 0;
}

}  // namespace intaglio::motion
