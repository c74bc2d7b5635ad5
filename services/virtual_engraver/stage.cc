#include "services/virtual_engraver/stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

// Lag. An axis follows its command u with x' = (u - x) / tau. For a cubic u the
// particular solution is q = u - tau u' + tau^2 u'' - tau^3 u''' (insert it: q + tau q' =
// u, as the fourth derivative is zero), so over any piece of a cubic the exact state is
//   x(t) = q(t) + (x(t0) - q(t0)) exp(-(t - t0) / tau).

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;
constexpr double kNmPerMm = 1e6;
constexpr std::uint64_t kSubticksPerTick = 65536;

Vec3 ToMm(std::int32_t x, std::int32_t y, std::int32_t z) {
  return Vec3(x, y, z) / kNmPerMm;
}

std::int32_t ToNm(double mm) {
  return static_cast<std::int32_t>(
      std::llround(std::clamp(mm * kNmPerMm, -2.1e9, 2.1e9)));
}

Vec3 EndOf(const link::WireSegment& s) { return ToMm(s.x_nm, s.y_nm, s.z_nm); }
Vec3 EndSpeedOf(const link::WireSegment& s) {
  return ToMm(s.vx_nm_s, s.vy_nm_s, s.vz_nm_s);
}

}  // namespace

Stage::Stage(const StageOptions& options) : options_(options) {
  commanded_mm_ = actual_mm_ = knot_mm_ =
      Vec3::Zero().cwiseMax(options.travel_min_mm).cwiseMin(options.travel_max_mm);
}

void Stage::BeginRun(const link::BeginRun& run) {
  if (phase_ != Phase::kRest || fault_ != StageFault::kNone)
    return Fail(StageFault::kRunRefused);
  if (run.start_tick <= tick_) {
    fault_ = StageFault::kLate;
    return;
  }
  run_ = run.run;
  start_tick_ = run.start_tick;
  taken_ = queued_subticks_ = in_segment_subticks_ = 0;
  queue_.clear();
  knot_mm_ = commanded_mm_;
  knot_mm_s_ = Vec3::Zero();
  phase_ = Phase::kRunning;
}

void Stage::Append(const link::Segments& segments) {
  if (phase_ != Phase::kRunning || segments.run != run_) return;
  if (segments.first_number != taken_ ||
      queue_.size() + segments.segments.size() > options_.queue_capacity) {
    return Fail(StageFault::kBadSequence);
  }
  for (const link::WireSegment& segment : segments.segments) {
    const Vec3 end = EndOf(segment);
    if (!Box3{options_.travel_min_mm, options_.travel_max_mm}.Contains(end)) {
      return Fail(StageFault::kLimit);
    }
    queue_.push_back(segment);
    queued_subticks_ += segment.duration_subticks;
    ++taken_;
  }
}

void Stage::Reset() {
  if (phase_ == Phase::kRest) fault_ = StageFault::kNone;
}

void Stage::Stick(int axis) {
  for (int i = 0; i < 3; ++i) {
    if (axis < 0 || axis == i) stuck_[static_cast<std::size_t>(i)] = true;
  }
}

// The command brakes along its direction with constant acceleration: one cubic whose
// end lies half the braking time ahead.
void Stage::Brake(StageFault fault) {
  if (fault_ == StageFault::kNone) fault_ = fault;
  queue_.clear();
  queued_subticks_ = in_segment_subticks_ = 0;
  if (phase_ == Phase::kRest) return;
  const double seconds = commanded_mm_s_.norm() / options_.brake_acceleration_mm_s2;
  if (seconds <= 0 || tick_ < start_tick_) {
    phase_ = Phase::kRest;
    commanded_mm_s_ = Vec3::Zero();
    return;
  }
  const Vec3 end = commanded_mm_ + 0.5 * seconds * commanded_mm_s_;
  link::WireSegment stop;
  stop.x_nm = ToNm(end.x());
  stop.y_nm = ToNm(end.y());
  stop.z_nm = ToNm(end.z());
  stop.duration_subticks = static_cast<std::uint32_t>(std::clamp(
      std::ceil(seconds * rate_hz_ * static_cast<double>(kSubticksPerTick)), 1.0, 4e9));
  stop.program_end = true;
  queue_.push_back(stop);
  queued_subticks_ = stop.duration_subticks;
  knot_mm_ = commanded_mm_;
  knot_mm_s_ = commanded_mm_s_;
  phase_ = Phase::kBraking;
}

bool Stage::MayPass() const {
  if (phase_ != Phase::kRunning || tick_ + 1 <= start_tick_) return true;
  const bool ends = !queue_.empty() && queue_.back().program_end;
  return ends || queued_subticks_ - in_segment_subticks_ >= kSubticksPerTick;
}

Stage::Curve Stage::CurveOf(const Vec3& p0, const Vec3& v0, const Vec3& p1,
                            const Vec3& v1, double duration_s) {
  const Vec3 mean = (p1 - p0) / duration_s;
  return {p0, v0, (3 * mean - 2 * v0 - v1) / duration_s,
          (v0 + v1 - 2 * mean) / (duration_s * duration_s)};
}

void Stage::FollowCurve(const Curve& curve, double from_s, double to_s) {
  const double tau = options_.lag_s;
  const auto command = [&](double s) {
    return Vec3(curve.p + s * (curve.v + s * (curve.c2 + s * curve.c3)));
  };
  const auto speed = [&](double s) {
    return Vec3(curve.v + s * (2 * curve.c2 + 3 * s * curve.c3));
  };
  const auto particular = [&](double s) {
    return Vec3(command(s) - tau * speed(s) +
                tau * tau * (2 * curve.c2 + 6 * s * curve.c3) -
                6 * tau * tau * tau * curve.c3);
  };
  commanded_mm_ = command(to_s);
  commanded_mm_s_ = speed(to_s);
  const double fade = tau > 0 ? std::exp(-(to_s - from_s) / tau) : 0;
  const Vec3 next = particular(to_s) + fade * (actual_mm_ - particular(from_s));
  for (int axis = 0; axis < 3; ++axis) {
    if (!stuck_[static_cast<std::size_t>(axis)]) actual_mm_[axis] = next[axis];
  }
}

void Stage::FinishSegment() {
  const link::WireSegment segment = queue_.front();
  queue_.pop_front();
  queued_subticks_ -= segment.duration_subticks;
  in_segment_subticks_ = 0;
  knot_mm_ = EndOf(segment);
  knot_mm_s_ = EndSpeedOf(segment);
  if (segment.program_end) {
    phase_ = Phase::kRest;
    queue_.clear();
    queued_subticks_ = 0;
    commanded_mm_ = knot_mm_;
    commanded_mm_s_ = Vec3::Zero();
  }
}

std::uint64_t Stage::FollowQueue(std::uint64_t left, double rate_hz) {
  const double subtick_s = 1 / (rate_hz * static_cast<double>(kSubticksPerTick));
  while (left > 0 && !queue_.empty()) {
    const link::WireSegment segment = queue_.front();
    const std::uint64_t step =
        std::min<std::uint64_t>(left, segment.duration_subticks - in_segment_subticks_);
    const Curve curve = CurveOf(knot_mm_, knot_mm_s_, EndOf(segment), EndSpeedOf(segment),
                                segment.duration_subticks * subtick_s);
    const double from_s = static_cast<double>(in_segment_subticks_) * subtick_s;
    FollowCurve(curve, from_s, from_s + static_cast<double>(step) * subtick_s);
    in_segment_subticks_ += step;
    left -= step;
    if (in_segment_subticks_ < segment.duration_subticks) continue;
    in_position_ = left == 0 && segment.pulse && phase_ == Phase::kRunning &&
                   (actual_mm_ - EndOf(segment)).norm() <= options_.position_tolerance_mm;
    FinishSegment();
  }
  return left;
}

void Stage::RunTick(double rate_hz) {
  std::uint64_t left = FollowQueue(kSubticksPerTick, rate_hz);
  if (phase_ == Phase::kRunning && left > 0) {
    Fail(StageFault::kStarved);
    left = FollowQueue(left, rate_hz);  // brakes at once, without a pause to the tick
  }
  // At rest the lag goes on.
  const double rest_s =
      static_cast<double>(left) / (rate_hz * static_cast<double>(kSubticksPerTick));
  if (left > 0) FollowCurve({commanded_mm_}, 0, rest_s);
}

void Stage::AdvanceTick(double rate_hz) {
  ++tick_;
  rate_hz_ = rate_hz;
  in_position_ = false;
  const bool executing =
      phase_ == Phase::kBraking || (phase_ == Phase::kRunning && tick_ > start_tick_);
  if (executing) {
    RunTick(rate_hz);
    Latch();
  } else {
    FollowCurve({commanded_mm_}, 0, 1 / rate_hz);
  }
  const double error = (commanded_mm_ - actual_mm_).cwiseAbs().maxCoeff();
  following_error_max_mm_ = std::max(following_error_max_mm_, error);
  if (error > options_.following_error_limit_mm && fault_ == StageFault::kNone) {
    Fail(StageFault::kFollowingError);
  }
}

void Stage::Latch() {
  if (latched_.empty() || latched_.back().run != run_ ||
      latched_.back().positions.size() >= link::kMaxPositions ||
      latched_.back().first_tick + latched_.back().positions.size() != tick_) {
    latched_.push_back({run_, tick_, {}});
  }
  latched_.back().positions.push_back(
      {ToNm(actual_mm_.x()), ToNm(actual_mm_.y()), ToNm(actual_mm_.z())});
}

std::vector<link::Positions> Stage::TakePositions() {
  return std::exchange(latched_, {});
}

link::MotionStatus Stage::Report() {
  link::MotionStatus status;
  status.tick = tick_;
  status.x_nm = ToNm(actual_mm_.x());
  status.y_nm = ToNm(actual_mm_.y());
  status.z_nm = ToNm(actual_mm_.z());
  status.vx_nm_s = ToNm(commanded_mm_s_.x());
  status.vy_nm_s = ToNm(commanded_mm_s_.y());
  status.vz_nm_s = ToNm(commanded_mm_s_.z());
  status.run = run_;
  const std::uint64_t from = std::max(tick_, start_tick_);
  status.covered_through_tick =
      from + (queued_subticks_ - in_segment_subticks_) / kSubticksPerTick;
  status.queue_free = options_.queue_capacity - static_cast<std::uint32_t>(queue_.size());
  status.segments_taken = taken_;
  status.at_rest = phase_ == Phase::kRest;
  status.fault = fault_;
  status.following_error_max_nm =
      static_cast<std::uint32_t>(std::max(0, ToNm(following_error_max_mm_)));
  following_error_max_mm_ = 0;
  return status;
}

link::MotionIdentity Stage::Identity() const {
  link::MotionIdentity identity;
  for (int axis = 0; axis < 3; ++axis) {
    identity.travel_min_nm[axis] = ToNm(options_.travel_min_mm[axis]);
    identity.travel_max_nm[axis] = ToNm(options_.travel_max_mm[axis]);
  }
  identity.queue_capacity = options_.queue_capacity;
  return identity;
}

}  // namespace intaglio::virtual_engraver
