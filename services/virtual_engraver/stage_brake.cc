// A run that is ended in its midst: the way of the command to rest.

#include <algorithm>
#include <cmath>

#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {

Vec3 Stage::StopSeconds() const {
  const Vec3& v_mm_s = commanded_mm_s_;
  if (options_.mirror_brake_mm_s2 <= 0)
    return Vec3::Constant(AtFocus(v_mm_s).norm() / options_.brake_acceleration_mm_s2);
  const double mirrors_s = v_mm_s.head<2>().norm() / options_.mirror_brake_mm_s2;
  return {mirrors_s, mirrors_s, std::abs(v_mm_s.z()) / options_.brake_acceleration_mm_s2};
}

Stage::Piece Stage::StopPiece(const Vec3& stop_s, double from_s, double to_s) const {
  Piece piece;
  for (int axis = 0; axis < 3; ++axis) {
    const double s = std::min(to_s, stop_s[axis]);
    const double left = stop_s[axis] > 0 ? 1 - s / stop_s[axis] : 0;
    piece.end_mm_s[axis] = left * commanded_mm_s_[axis];
    piece.end_mm[axis] =
        commanded_mm_[axis] + 0.5 * (1 + left) * s * commanded_mm_s_[axis];
  }
  if (options_.mirror_brake_mm_s2 > 0) {
    piece.end_mm =
        piece.end_mm.cwiseMax(options_.travel_min_mm).cwiseMin(options_.travel_max_mm);
  }
  piece.units = static_cast<std::uint64_t>(
      std::clamp(std::ceil((to_s - from_s) / unit_s_), 1.0, 4e18));
  return piece;
}

// The command brakes along its direction with constant acceleration: one cubic whose
// end lies half the braking time ahead. Mirrors are at rest long before z is.
void Stage::Brake(link::StageFault fault) {
  if (fault_ == link::StageFault::kNone) fault_ = fault;
  axes_->LeaveAt(DoneRatio());
  queue_.clear();
  queued_units_ = in_piece_units_ = 0;
  passed_ = {};
  if (phase_ == Phase::kRest) return;
  if (phase_ == Phase::kJogging) return BrakeJog();
  const Vec3 stop_s = StopSeconds();
  if (stop_s.maxCoeff() <= 0 || now_units_ < start_units_) {
    phase_ = Phase::kRest;
    commanded_mm_s_ = Vec3::Zero();
    return;
  }
  if (stop_s.minCoeff() > 0 && stop_s.minCoeff() < stop_s.maxCoeff())
    queue_.push_back(StopPiece(stop_s, 0, stop_s.minCoeff()));
  const double first_s = queue_.empty() ? 0 : stop_s.minCoeff();
  queue_.push_back(StopPiece(stop_s, first_s, stop_s.maxCoeff()));
  queue_.back().program_end = true;
  for (const Piece& piece : queue_) queued_units_ += piece.units;
  knot_mm_ = commanded_mm_;
  knot_mm_s_ = commanded_mm_s_;
  phase_ = Phase::kBraking;
}

}  // namespace intaglio::virtual_engraver
