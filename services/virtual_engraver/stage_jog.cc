// Motion by hand of the stage, and of the one that carries the block.

#include <algorithm>
#include <cmath>

#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr double kHomeSpeedMmS = 20;
// Slower than braking, as a person wants it.
constexpr double kJogAccelerationRatio = 0.1;

}  // namespace

void Stage::SetAir(bool on) {
  if (!options_.floats_on_air || on == has_air_) return;
  has_air_ = on;
  if (!on) Brake(link::StageFault::kNoAir);
  // Whatever was wrong before.
  fault_ = on ? link::StageFault::kAirReturned : link::StageFault::kNoAir;
}

void Stage::Jog(const link::JogMove& jog) {
  ++jogs_taken_;
  StartJog(Vec3(jog.x_nm, jog.y_nm, jog.z_nm) / kNmPerMm, jog.speed_nm_s / kNmPerMm);
}

// With absolute encoders home is where the axes were at power-up.
void Stage::Home() {
  ++jogs_taken_;
  if (options_.homing) return StartHoming();
  StartJog(StartMm(options_), kHomeSpeedMmS);
}

void Stage::StartJog(const Vec3& target, double speed_mm_s) {
  if (phase_ != Phase::kRest || fault_ != link::StageFault::kNone || !knows_place_)
    return;
  if (!Box3{options_.travel_min_mm, options_.travel_max_mm}.Contains(target))
    return Fail(link::StageFault::kLimit);
  const double length_mm = AtFocus(target - commanded_mm_).norm();
  if (length_mm <= 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    const double way = std::abs(target[axis] - commanded_mm_[axis]);
    if (way > 0)
      speed_mm_s = std::min(speed_mm_s, options_.max_speed_mm_s[axis] * length_mm / way);
  }
  jog_.emplace(commanded_mm_, target, length_mm, speed_mm_s,
               kJogAccelerationRatio * options_.brake_acceleration_mm_s2);
  phase_ = Phase::kJogging;
}

void Stage::MoveBlock(const link::MoveBlock& move) {
  ++jogs_taken_;
  if (!block_ || phase_ != Phase::kRest || fault_ != link::StageFault::kNone) return;
  const Vec2 place_mm = Vec2(move.x_nm, move.y_nm) / kNmPerMm;
  if (!block_->Reaches(place_mm)) return Fail(link::StageFault::kLimit);
  block_->MoveTo(place_mm, move.speed_nm_s / kNmPerMm);
  if (block_->moves()) phase_ = Phase::kJogging;
}

void Stage::PushBlock(const Vec2& by_mm) {
  if (!block_) return;
  block_->Push(by_mm);
  if (phase_ == Phase::kJogging && !jog_ && !home_) phase_ = Phase::kRest;
  if (phase_ == Phase::kRunning && !IsBlockAt(run_block_mm_))
    Fail(link::StageFault::kBlockPlace);
}

bool Stage::RefusesPlace(std::int32_t block_x_nm, std::int32_t block_y_nm) {
  run_block_mm_ = Vec2(block_x_nm, block_y_nm) / kNmPerMm;
  if (IsBlockAt(run_block_mm_)) return false;
  Fail(link::StageFault::kBlockPlace);
  return true;
}

bool Stage::IsBlockAt(const Vec2& place_mm) const {
  return (block_mm() - place_mm).norm() <= options_.position_tolerance_mm;
}

void Stage::BrakeJog() {
  if (home_) {
    home_->Brake();
    if (home_->state() == HomeCourse::State::kHeld) EndHomeLeg();
  } else if (jog_) {
    jog_->Brake();
  } else {
    block_->Brake();
  }
}

void Stage::AdvanceJog(double seconds) {
  if (home_) return AdvanceHome(seconds);
  if (phase_ == Phase::kJogging && !jog_) {
    block_->Advance(seconds);
    if (!block_->moves()) phase_ = Phase::kRest;
    return;
  }
  while (phase_ == Phase::kJogging && seconds > 0) {
    const JogCourse::Stretch stretch = jog_->Next(seconds);
    FollowCurve(stretch.curve, 0, stretch.seconds);
    seconds -= stretch.seconds;
    if (!jog_->done()) continue;
    jog_.reset();
    Rest();
    if (seconds > 0) FollowCurve({commanded_mm_}, 0, seconds);
  }
}

}  // namespace intaglio::virtual_engraver
