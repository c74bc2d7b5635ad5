#include "services/virtual_engraver/stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/virtual_engraver/axes/virtual_axes.h"

namespace intaglio::virtual_engraver {
namespace {

using link::StageFault;

Vec3 ToMm(std::int32_t x, std::int32_t y, std::int32_t z) {
  return Vec3(x, y, z) / kNmPerMm;
}

Vec3 EndVelocityMmS(const auto& s, std::uint32_t unit_nm_s) {
  return unit_nm_s * Vec3(s.vx_counts, s.vy_counts, s.vz_counts) / kNmPerMm;
}

std::int32_t ToNm(double mm) {
  return static_cast<std::int32_t>(
      std::llround(std::clamp(mm * kNmPerMm, -2.1e9, 2.1e9)));
}

// How far from a knot's time the in-position output may be on. At 80 mm/s the stage makes
// 28 um of it, below the tolerance of 30 um of such a machine; and a quarter of a tick
// keeps it from the next pulse.
constexpr double kGateSeconds = 0.00035;
constexpr double kGateTickRatio = 0.25;

}  // namespace

Vec3 StartMm(const StageOptions& options) {
  return options.start_mm.cwiseMax(options.travel_min_mm).cwiseMin(options.travel_max_mm);
}

Stage::Stage(const StageOptions& options)
    : Stage(options, std::make_unique<VirtualAxes>(
                         VirtualAxesOptions{options.mechanics, options.vibration,
                                            options.backlash_mm, options.repeatability_mm,
                                            options.repeatability_seed},
                         StartMm(options))) {}

Stage::Stage(const StageOptions& options, std::unique_ptr<StageAxes> axes)
    : options_(options),
      knot_mm_(StartMm(options)),
      commanded_mm_(knot_mm_),
      axes_(std::move(axes)),
      knows_place_(!options.homing) {
  if (options.block_stage) block_.emplace(*options.block_stage);
  if (!options.own_clock) return;
  own_clock_.emplace(*options.own_clock);
  now_units_ = own_clock_->now_ns();
  unit_s_ = 1e-9;
}

bool Stage::Refuses(bool timed) {
  if (phase_ == Phase::kRest && fault_ == StageFault::kNone &&
      timed == own_clock_.has_value())
    return false;
  Fail(StageFault::kRunRefused);
  return true;
}

void Stage::Start(std::uint32_t run, std::uint64_t start_units) {
  if (start_units <= now_units_) {
    fault_ = StageFault::kLate;
    return;
  }
  run_ = run;
  ++runs_begun_;
  start_units_ = start_units;
  taken_ = queued_units_ = in_piece_units_ = 0;
  queue_.clear();
  passed_ = {};
  knot_mm_ = commanded_mm_;
  knot_mm_s_ = Vec3::Zero();
  phase_ = Phase::kRunning;
}

void Stage::BeginRun(const link::BeginRun& run) {
  if (Refuses(false) || RefusesWithoutPlace(run.run) ||
      RefusesPlace(run.block_x_nm, run.block_y_nm))
    return;
  // Beyond this there are no subticks.
  if (run.start_tick > UINT64_MAX / kSubticksPerTick) return Fail(StageFault::kLate);
  Start(run.run, run.start_tick * kSubticksPerTick);
}

void Stage::BeginTimedRun(const link::BeginTimedRun& run) {
  if (Refuses(true) || RefusesWithoutPlace(run.run) ||
      RefusesPlace(run.block_x_nm, run.block_y_nm))
    return;
  Start(run.run, run.start_ns);
  last_end_ns_ = run.start_ns;
}

bool Stage::TakesSegments(std::uint32_t run, std::uint64_t first_number,
                          std::size_t count) {
  if (phase_ != Phase::kRunning || run != run_) return false;
  if (first_number == taken_ && queue_.size() + count <= options_.queue_capacity)
    return true;
  Fail(StageFault::kBadSequence);
  return false;
}

bool Stage::Queue(const Piece& piece) {
  if (!Box3{options_.travel_min_mm, options_.travel_max_mm}.Contains(piece.end_mm)) {
    Fail(StageFault::kLimit);
    return false;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(piece.end_mm_s[axis]) <= options_.max_speed_mm_s[axis]) continue;
    fault_axes_ = {};
    fault_axes_[static_cast<std::size_t>(axis)] = true;
    Fail(StageFault::kTooFast);
    return false;
  }
  queue_.push_back(piece);
  queued_units_ += piece.units;
  ++taken_;
  return true;
}

void Stage::Append(const link::Segments& segments) {
  if (!TakesSegments(segments.run, segments.first_number, segments.segments.size()))
    return;
  for (const link::WireSegment& s : segments.segments) {
    if (!Queue({ToMm(s.x_nm, s.y_nm, s.z_nm),
                EndVelocityMmS(s, options_.velocity_unit_nm_s), s.duration_subticks,
                s.pulse, s.program_end}))
      return;
  }
}

void Stage::AppendTimed(const link::TimedSegments& segments) {
  if (!TakesSegments(segments.run, segments.first_number, segments.segments.size()))
    return;
  for (const link::WireTimedSegment& s : segments.segments) {
    if (s.end_ns <= last_end_ns_) return Fail(StageFault::kBadSequence);
    if (!Queue({ToMm(s.x_nm, s.y_nm, s.z_nm),
                EndVelocityMmS(s, options_.velocity_unit_nm_s), s.end_ns - last_end_ns_,
                s.pulse, s.program_end}))
      return;
    last_end_ns_ = s.end_ns;
  }
}

void Stage::Reset() {
  if (phase_ != Phase::kRest || !has_air_ || drives_ != StageFault::kNone) return;
  fault_ = StageFault::kNone;
  fault_axes_ = {};
}

bool Stage::MayPass(double rate_hz) const {
  if (phase_ != Phase::kRunning) return true;
  const std::uint64_t next =
      own_clock_ ? own_clock_->NsAfter(1 / rate_hz) : now_units_ + kSubticksPerTick;
  if (next <= start_units_) return true;
  const bool ends = !queue_.empty() && queue_.back().program_end;
  return ends ||
         queued_units_ - in_piece_units_ >= next - std::max(now_units_, start_units_);
}

CubicCommand Stage::CurveOf(const Vec3& p0, const Vec3& v0, const Vec3& p1,
                            const Vec3& v1, double duration_s) {
  const Vec3 mean = (p1 - p0) / duration_s;
  return {p0, v0, (3 * mean - 2 * v0 - v1) / duration_s,
          (v0 + v1 - 2 * mean) / (duration_s * duration_s)};
}

void Stage::FollowCurve(const CubicCommand& curve, double from_s, double to_s) {
  commanded_mm_ = curve.At(to_s);
  commanded_mm_s_ = curve.SpeedAt(to_s);
  axes_->Follow(curve, from_s, to_s);
}

double Stage::DoneRatio() const {
  if (in_piece_units_ == 0) return 0;
  return static_cast<double>(in_piece_units_) / static_cast<double>(queue_.front().units);
}

Vec3 Stage::place_mm() const { return actual_mm() + axes_->BesideMm(DoneRatio()); }

void Stage::FinishPiece() {
  const Piece piece = queue_.front();
  axes_->PassEnd();
  queue_.pop_front();
  queued_units_ -= piece.units;
  in_piece_units_ = 0;
  knot_mm_ = piece.end_mm;
  knot_mm_s_ = piece.end_mm_s;
  if (phase_ == Phase::kRunning && (piece.pulse || !own_clock_))
    passed_ = {axes_->expected_mm().value_or(PlaceOf(piece)), piece.end_mm, now_units_,
               piece.pulse};
  if (piece.program_end) {
    phase_ = Phase::kRest;
    queue_.clear();
    queued_units_ = 0;
    commanded_mm_ = knot_mm_;
    commanded_mm_s_ = Vec3::Zero();
  }
}

std::uint64_t Stage::FollowQueue(std::uint64_t left) {
  while (left > 0 && !queue_.empty()) {
    const Piece& piece = queue_.front();
    const std::uint64_t step = std::min(left, piece.units - in_piece_units_);
    const CubicCommand curve = CurveOf(knot_mm_, knot_mm_s_, piece.end_mm, piece.end_mm_s,
                                       static_cast<double>(piece.units) * unit_s_);
    const double from_s = static_cast<double>(in_piece_units_) * unit_s_;
    FollowCurve(curve, from_s, from_s + static_cast<double>(step) * unit_s_);
    in_piece_units_ += step;
    now_units_ += step;
    left -= step;
    if (in_piece_units_ == piece.units) FinishPiece();
  }
  return left;
}

// Waits for the start, follows the queue, rests.
void Stage::AdvanceTo(std::uint64_t units) {
  if (phase_ == Phase::kRunning && now_units_ < start_units_) {
    const std::uint64_t wait = std::min(units, start_units_) - now_units_;
    FollowCurve({commanded_mm_}, 0, static_cast<double>(wait) * unit_s_);
    now_units_ += wait;
  }
  std::uint64_t left = FollowQueue(units - now_units_);
  if (phase_ == Phase::kRunning && left > 0) {
    Fail(StageFault::kStarved);
    left = FollowQueue(left);  // brakes at once, without a pause to the tick
  }
  // At rest the lag goes on.
  if (left > 0 && phase_ != Phase::kJogging)
    FollowCurve({commanded_mm_}, 0, static_cast<double>(left) * unit_s_);
  now_units_ += left;
}

// Notices that arrive between two ticks, and at the newer one if the line has no delay.
void Stage::AdvanceOwnClock() {
  own_clock_->Advance(1 / rate_hz_);
  own_clock_->ReceiveTick(tick_);
  const std::uint64_t now_ns = own_clock_->now_ns();
  while (const auto received = own_clock_->ReceivesBy(now_ns)) {
    AdvanceTo(received->at_ns);
    LatchAt(*received);
  }
  AdvanceTo(now_ns);
}

void Stage::AdvanceTick(double rate_hz) {
  ++tick_;
  rate_hz_ = rate_hz;
  const bool executing = phase_ == Phase::kBraking ||
                         (phase_ == Phase::kRunning && now_units_ >= start_units_);
  if (own_clock_) {
    AdvanceOwnClock();
  } else {
    unit_s_ = 1 / (rate_hz * static_cast<double>(kSubticksPerTick));
    AdvanceTo(now_units_ + kSubticksPerTick);
    if (executing) Latch();
  }
  CheckPlace();
}

void Stage::CheckPlace() {
  in_position_ = GateIsOn();
  const double error = AtFocus(commanded_mm_ - actual_mm()).cwiseAbs().maxCoeff();
  following_error_max_mm_ = std::max(following_error_max_mm_, error);
  if (error <= options_.following_error_limit_mm || fault_ != StageFault::kNone) return;
  // Steps that are made up for too fast may be lost.
  if (options_.homing) knows_place_ = false;
  Fail(StageFault::kFollowingError);
}

// On its own clock the place is taken as exactly as it is known, and with a lag of many
// times the tolerance.
Vec3 Stage::PlaceOf(const Piece& piece) const {
  if (!own_clock_ && options_.mechanics.first_order()) return piece.end_mm;
  return piece.end_mm - axes_->velocity_lag_s().cwiseProduct(piece.end_mm_s);
}

bool Stage::IsAt(const Vec3& place_mm) const {
  return AtFocus(actual_mm() - place_mm).norm() <= options_.position_tolerance_mm;
}

bool Stage::GateIsOn() const {
  const double window_s = std::min(kGateSeconds, kGateTickRatio / rate_hz_);
  const std::uint64_t window =
      own_clock_ ? static_cast<std::uint64_t>(window_s / unit_s_) : 0;
  if (passed_.pulse && now_units_ - passed_.at_units <= window && IsAt(passed_.at_mm))
    return true;
  if (phase_ != Phase::kRunning || now_units_ < start_units_) return false;
  std::uint64_t to_end = 0, done = in_piece_units_;
  for (const Piece& piece : queue_) {
    to_end += piece.units - done;
    done = 0;
    if (to_end > window) return false;
    if (piece.pulse && IsAt(PlaceOf(piece))) return true;
  }
  return false;
}

void Stage::Latch() {
  if (latched_.empty() || latched_.back().run != run_ ||
      latched_.back().positions.size() >= link::kMaxPositions ||
      latched_.back().first_tick + latched_.back().positions.size() != tick_)
    latched_.push_back({run_, tick_, {}});
  latched_.back().positions.push_back(
      {ToNm(actual_mm().x()), ToNm(actual_mm().y()), ToNm(actual_mm().z())});
}

void Stage::LatchAt(const OwnClock::Received& received) {
  received_tick_ = received.tick;
  if (timed_latched_.empty() || timed_latched_.back().run != run_ ||
      timed_latched_.back().positions.size() >= link::kMaxTimedPositions)
    timed_latched_.push_back({run_, received.tick, {}});
  timed_latched_.back().positions.push_back({received.at_ns, ToNm(actual_mm().x()),
                                             ToNm(actual_mm().y()),
                                             ToNm(actual_mm().z())});
}

link::MotionStatus Stage::Report() {
  link::MotionStatus status;
  status.tick = own_clock_ ? received_tick_ : tick_;
  status.x_nm = ToNm(actual_mm().x());
  status.y_nm = ToNm(actual_mm().y());
  status.z_nm = ToNm(actual_mm().z());
  const Vec3 speed = commanded_mm_s_ / options_.velocity_unit_nm_s;
  status.vx_counts = ToNm(speed.x());
  status.vy_counts = ToNm(speed.y());
  status.vz_counts = ToNm(speed.z());
  status.run = run_;
  // How far that is in ticks only the host can know when the clock is not the lamp's.
  status.covered_through_tick =
      own_clock_
          ? 0
          : (std::max(now_units_, start_units_) + queued_units_ - in_piece_units_) /
                kSubticksPerTick;
  status.queue_free = options_.queue_capacity - static_cast<std::uint32_t>(queue_.size());
  status.segments_taken = taken_;
  status.at_rest = phase_ == Phase::kRest && axes_->settled();
  status.place_lost = !knows_place_;
  status.fault_axes = fault_axes_;
  status.fault = fault_;
  status.following_error_max_nm =
      static_cast<std::uint32_t>(std::max(0, ToNm(following_error_max_mm_)));
  following_error_max_mm_ = 0;
  status.jogs_taken = jogs_taken_;
  status.block_x_nm = ToNm(block_mm().x());
  status.block_y_nm = ToNm(block_mm().y());
  return status;
}

link::MotionIdentity Stage::Identity() const {
  link::MotionIdentity identity;
  for (int axis = 0; axis < 3; ++axis) {
    identity.travel_min_nm[axis] = ToNm(options_.travel_min_mm[axis]);
    identity.travel_max_nm[axis] = ToNm(options_.travel_max_mm[axis]);
  }
  identity.queue_capacity = options_.queue_capacity;
  identity.serial_number = options_.serial_number;
  identity.compares_place = !own_clock_;
  identity.watches_air = options_.floats_on_air;
  identity.moves_block = block_.has_value();
  identity.velocity_unit_nm_s = options_.velocity_unit_nm_s;
  return identity;
}

link::StageTolerance Stage::Tolerance() const {
  return {static_cast<std::uint32_t>(ToNm(options_.position_tolerance_mm))};
}

std::optional<link::StageSpeed> Stage::MaxSpeed() const {
  const Vec3& max_mm_s = options_.max_speed_mm_s;
  if (!(max_mm_s.minCoeff() < std::numeric_limits<double>::infinity())) return {};
  const auto counts = [&](int axis) {
    constexpr double kMax = std::numeric_limits<std::uint32_t>::max();
    const double exact = 1e6 * max_mm_s[axis] / options_.velocity_unit_nm_s;
    return static_cast<std::uint32_t>(std::clamp(std::floor(exact), 1.0, kMax));
  };
  return link::StageSpeed{counts(0), counts(1), counts(2)};
}

}  // namespace intaglio::virtual_engraver
