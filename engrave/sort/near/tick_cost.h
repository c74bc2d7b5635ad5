#pragma once

// The cost of an order for the stage, from its steps alone and without planning the
// motion: fast enough to be computed a million times per second while orders are
// compared.
//
// A step d made in n ticks of T has the mean velocity d / (n T). From the middle of one
// step to the middle of the next an axis changes its velocity by no more than its
// acceleration limit allows in that time:
//   |d2 / n2 - d1 / n1| <= A T^2 (n1 + n2) / 2.
// That is necessary, not sufficient; way_speeds.h has the exact condition. The used share
// of this limit, squared and weighted, is added to the ticks: a smaller share leaves the
// next changes more freedom, and the planner what it needs for further limits.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"

namespace intaglio::sort {

/// A place or step per axis in units of A T^2, the length that the acceleration limit
/// adds to a step from one tick to the next.
struct Scaled {
  float x = 0;
  float y = 0;
  float z = 0;

  Scaled operator-(const Scaled& o) const { return {x - o.x, y - o.y, z - o.z}; }
};

/// A step and the ticks it is made in, > 0.
struct TimedMove {
  Scaled step;
  float ticks = 1;
};

/// Which ticks a step may have.
enum class Fit {
  /// Those that fit the steps beside it, which is necessary. Where the axes need many
  /// steps to get faster, an order so changes to what they cannot follow yet.
  kNeighbours,
  /// Those with which the axes can make the whole way (way_speeds.h). Where a step takes
  /// few ticks, the planner needs no more; with neighbours alone it needs 2 % more.
  kWay,
};

class TickCost {
 public:
  /// limits: in the frame of the points. rate_hz: 1..50000.
  TickCost(const motion::Limits& limits, double rate_hz, Fit fit = Fit::kWay);

  Scaled Scale(const Vec3& mm) const {
    return {static_cast<float>(mm.x() * per_mm_.x()),
            static_cast<float>(mm.y() * per_mm_.y()),
            static_cast<float>(mm.z() * per_mm_.z())};
  }

  /// The fewest ticks that the speed limits allow, >= 1.
  float MinTicks(const Scaled& step) const {
    const float ticks =
        std::max({std::abs(step.x) * per_speed_.x, std::abs(step.y) * per_speed_.y,
                  std::abs(step.z) * per_speed_.z}) *
        (1 - 1e-6F);
    // Larger floats are whole. std::ceil is a call where the processor is not known.
    constexpr float kWhole = 1 << 23;
    if (!(ticks < kWhole)) return ticks;
    const auto below = static_cast<float>(static_cast<std::int32_t>(ticks));
    return std::max(1.0F, below < ticks ? below + 1 : below);
  }

  /// The share of the limit of acceleration between two steps.
  static float Bend(const TimedMove& a, const TimedMove& b) {
    const float p = 1 / a.ticks, q = 1 / b.ticks;
    const float largest = std::max({std::abs(b.step.x * q - a.step.x * p),
                                    std::abs(b.step.y * q - a.step.y * p),
                                    std::abs(b.step.z * q - a.step.z * p)});
    return 2 * largest / (a.ticks + b.ticks);
  }

  /// In ticks; more than any detour where the limit is passed.
  float BendCost(float bend) const {
    return bend_weight_ * bend * bend + (bend > 1 ? kForbidden * bend : 0);
  }

  double rate_hz() const { return rate_hz_; }
  Fit fit() const { return fit_; }
  /// The speed limits of the axes in A T.
  Vec3 TopSpeeds() const {
    return Vec3(per_speed_.x, per_speed_.y, per_speed_.z).cwiseInverse();
  }

  /// Ticks tried beyond the fewest, growing, the first 0. Steps from rest to rest take
  /// many ticks at high rates; in between, a tick more or less makes little difference.
  std::span<const float> Beyond() const;

  /// The fewest ticks of `step` after `before` within the limit.
  float TicksAfter(const TimedMove& before, const Scaled& step) const;

  /// Ticks that a step of `mm` takes from rest to rest on the slowest axis.
  double StopAndGoTicks(double mm) const;

  /// The maximum number of steps that BestTicks takes at once.
  static constexpr std::size_t kMaxSteps = 16;

  /// The cheapest ticks of `steps` (1..kMaxSteps) between two moves that stay as they
  /// are: writes them and returns their sum and the cost of all bends. Where that is more
  /// than `spare` ticks above the sum of the fewest, what is written is of no use, and
  /// the result is only known to be more: few choices have to be compared for a small
  /// spare.
  float BestTicks(const TimedMove& before, std::span<const Scaled> steps,
                  const TimedMove& after, float* ticks,
                  float spare = std::numeric_limits<float>::infinity()) const;

  /// The same of ticks that are given.
  float CostOf(const TimedMove& before, std::span<const TimedMove> moves,
               const TimedMove& after) const;

  static constexpr float kForbidden = 1000;

 private:
  Vec3 per_mm_;       ///< 1 / (A T^2)
  Scaled per_speed_;  ///< A T / V
  double rate_hz_;
  double acceleration_mm_s2_;  ///< the least
  bool many_choices_;
  Fit fit_;
  float bend_weight_;
};

}  // namespace intaglio::sort
