#pragma once

// What a guide laser draws, against the outline that it was told: the oracle is the
// distance of its place from the edges of the polygon, each millisecond in which it is
// on.

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "tests/services/drivers/rig_expect.h"

namespace intaglio::drivers {

inline constexpr double kGuideSpeedMmS = 400;

/// Beside `here`, and not symmetrical.
inline std::vector<Vec2> OutlineBeside(const Vec2& here) {
  return {here + Vec2(4, 3), here + Vec2(14, 5), here + Vec2(12, 13), here + Vec2(5, 9)};
}

/// Counts how often the guide laser comes to each corner.
class OutlineWatch {
 public:
  /// `name` of the guarantee; `tolerance_mm` of a place on each axis.
  OutlineWatch(std::string name, std::vector<Vec2> corners, double tolerance_mm)
      : name_(std::move(name)),
        corners_(std::move(corners)),
        tolerance_mm_(std::numbers::sqrt2 * tolerance_mm),
        is_near_(corners_.size(), false),
        visits_(corners_.size(), 0) {}

  /// Once a millisecond.
  void Receive(const Vec2& at, bool is_on) {
    if (is_on) TakeLit(at);
    was_on_ = is_on;
    before_ = at;
  }
  void ExpectEachCorner(int visits) const {
    for (const int count : visits_) {
      Expect(count >= visits,
             fmt::format("{}: a corner was drawn {} times", name_, count));
    }
  }

 private:
  // A corner was reached; the beam goes 0.4 mm in a millisecond.
  static constexpr double kNearMm = 0.5;

  double BesideMm(const Vec2& at) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const Vec2 from = corners_[i], way = corners_[(i + 1) % corners_.size()] - from;
      const double share = std::clamp((at - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (from + share * way - at).norm());
    }
    return nearest;
  }
  void TakeLit(const Vec2& at) {
    Expect(BesideMm(at) <= tolerance_mm_,
           fmt::format("{}: the guide laser is on {} mm beside the outline", name_,
                       BesideMm(at)));
    Expect(!was_on_ || (at - before_).norm() <= 1.02e-3 * kGuideSpeedMmS,
           name_ + ": the outline is drawn faster than it may be");
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const bool is_near = (at - corners_[i]).norm() <= kNearMm;
      if (is_near && !is_near_[i]) ++visits_[i];
      is_near_[i] = is_near;
    }
  }

  std::string name_;
  std::vector<Vec2> corners_;
  double tolerance_mm_;
  std::vector<bool> is_near_;
  std::vector<int> visits_;
  bool was_on_ = false;
  Vec2 before_ = Vec2::Zero();
};

}  // namespace intaglio::drivers
