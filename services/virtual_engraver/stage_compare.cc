#include <algorithm>

#include "services/virtual_engraver/stage.h"

// The compare output of the stage's controller. It samples the actual position many
// times a tick and is on for an instant when the distance from the knot begins to grow.

namespace intaglio::virtual_engraver {
namespace {

// At 80 mm/s the stage makes 1.6 um of it, so the nearest place is missed by at most
// 0.8 um.
constexpr double kSamplePeriodS = 20e-6;

}  // namespace

/// The stage from now on, if nothing is commanded anew.
class Stage::Ahead {
 public:
  explicit Ahead(const Stage& stage)
      : stage_(stage),
        axes_(*stage.axes_->mechanics()),
        piece_(stage.queue_.begin()),
        from_mm_(stage.knot_mm_),
        from_mm_s_(stage.knot_mm_s_),
        rests_(stage.phase_ == Phase::kRest) {}

  const Vec3& actual_mm() const { return axes_.actual_mm(); }

  /// At most `units` on; returns how many. 0: what is commanded then is not known yet.
  std::uint64_t Step(std::uint64_t units) {
    const double unit_s = stage_.unit_s_;
    if (rests_) {
      axes_.Follow({from_mm_}, 0, static_cast<double>(units) * unit_s);
      return units;
    }
    if (piece_ == stage_.queue_.end()) return 0;
    const std::uint64_t step = std::min(units, piece_->units - done_units_);
    const double from_s = static_cast<double>(done_units_) * unit_s;
    axes_.Follow(CurveOf(from_mm_, from_mm_s_, piece_->end_mm, piece_->end_mm_s,
                         static_cast<double>(piece_->units) * unit_s),
                 from_s, from_s + static_cast<double>(step) * unit_s);
    done_units_ += step;
    if (done_units_ == piece_->units) EndPiece();
    return step;
  }

 private:
  void EndPiece() {
    from_mm_ = piece_->end_mm;
    from_mm_s_ = piece_->end_mm_s;
    rests_ = piece_->program_end;
    done_units_ = 0;
    ++piece_;
  }

  const Stage& stage_;
  Mechanics axes_;
  std::deque<Piece>::const_iterator piece_;
  Vec3 from_mm_, from_mm_s_;
  bool rests_;
  std::uint64_t done_units_ = 0;
};

std::optional<Vec3> Stage::PlaceOfCompare() const {
  const bool at_knot = passed_.pulse && passed_.at_units == now_units_;
  if (own_clock_ || !at_knot || axes_->mechanics() == nullptr ||
      fault_ != link::StageFault::kNone)
    return std::nullopt;
  const auto period =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(kSamplePeriodS / unit_s_));
  Ahead ahead(*this);
  Vec3 nearest_mm = ahead.actual_mm();
  double min_distance_mm = AtFocus(nearest_mm - passed_.end_mm).norm();
  for (std::uint64_t left = kSubticksPerTick; left > 1;) {
    const std::uint64_t stepped = ahead.Step(std::min(period, left - 1));
    if (stepped == 0) break;
    left -= stepped;
    const double distance_mm = AtFocus(ahead.actual_mm() - passed_.end_mm).norm();
    if (distance_mm > min_distance_mm) break;
    min_distance_mm = distance_mm;
    nearest_mm = ahead.actual_mm();
  }
  if (min_distance_mm > options_.position_tolerance_mm) return std::nullopt;
  return nearest_mm + axes_->BesideMm(DoneRatio());
}

}  // namespace intaglio::virtual_engraver
