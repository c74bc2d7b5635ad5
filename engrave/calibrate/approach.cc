#include "engrave/calibrate/approach.h"

#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/point_plan.h"

// The plan is sampled densely. An axis has turned when it has gone back from its farthest
// place by more than the rounding of a plan.

namespace intaglio::calibrate {
namespace {

constexpr double kRoundingMm = 2e-6;
constexpr int kSamples = 16;  // of a segment: a cubic turns twice at most

class AxisWay {
 public:
  void Pass(double at_mm) {
    if (!begun_) {
      begun_ = true;
      turned_mm_ = farthest_mm_ = at_mm;
    }
    at_mm_ = at_mm;
    const double onwards_mm = (at_mm - farthest_mm_) * (up_ ? 1 : -1);
    if (onwards_mm >= 0) {
      farthest_mm_ = at_mm;
    } else if (onwards_mm < -kRoundingMm) {
      up_ = !up_;
      turned_mm_ = farthest_mm_;
      farthest_mm_ = at_mm;
    }
  }
  double direction() const {
    if (std::abs(at_mm_ - turned_mm_) < kKnownAfterMm) return 0;
    return up_ ? 1 : -1;
  }

 private:
  bool begun_ = false, up_ = true;
  double at_mm_ = 0, turned_mm_ = 0, farthest_mm_ = 0;
};

}  // namespace

std::vector<Approach> ApproachesOf(motion::PlanOptions plan, const PointList& axes) {
  Require(!axes.empty(), "there is no point");
  plan.compensated = false;
  std::vector<Approach> approaches(axes.size());
  std::array<AxisWay, 3> ways;
  motion::KnotState from{axes.front(), Vec3::Zero()};
  for (const motion::Segment& segment : motion::PlanPoints(plan, axes)) {
    const double duration_s =
        motion::DurationSeconds(segment.duration_subticks, plan.rate_hz);
    for (int s = 0; s <= kSamples; ++s) {
      const Vec3 at_mm =
          motion::HermitePosition(from, segment, duration_s * s / kSamples, duration_s);
      for (std::size_t k = 0; k < 3; ++k) ways[k].Pass(at_mm[static_cast<int>(k)]);
    }
    from = segment.end();
    if (segment.point < 0) continue;
    Approach& approach = approaches.at(static_cast<std::size_t>(segment.point));
    approach.speed_mm_s = segment.end_velocity_mm_s;
    for (std::size_t k = 0; k < 3; ++k) {
      approach.direction[static_cast<int>(k)] = ways[k].direction();
    }
  }
  return approaches;
}

}  // namespace intaglio::calibrate
