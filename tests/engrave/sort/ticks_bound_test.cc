#include "engrave/sort/ticks_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "engrave/core/check.h"
#include "engrave/motion/axis/axis_reach.h"
#include "engrave/sort/planned_ticks.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort {
namespace {

using motion::SpeedInterval;

/// The fewest ticks of all orders and of all ticks of their steps, with any velocity at
/// both ends: exact, because axes are independent and the speeds that an axis can reach
/// are intervals (motion/axis/axis_reach.h).
class EveryWay {
 public:
  EveryWay(const PointList& points_mm, const TicksBoundOptions& options)
      : points_mm_(points_mm), options_(options), used_(points_mm.size()) {}

  /// At most `known`.
  std::uint64_t FewestTicks(std::uint64_t known) {
    best_ = known;
    for (std::size_t first = 0; first < points_mm_.size(); ++first) {
      Speeds any;
      for (int axis = 0; axis < 3; ++axis) {
        const double top = options_.limits.max_speed_mm_s[axis];
        any[axis] = {-top, top};
      }
      used_[first] = true;
      GoOn(first, any, 0, points_mm_.size() - 1);
      used_[first] = false;
    }
    return best_;
  }

 private:
  using Speeds = SpeedInterval[3];

  void GoOn(std::size_t at, const Speeds& speeds, std::uint64_t ticks, std::size_t left) {
    if (left == 0) best_ = std::min(best_, ticks);
    for (std::size_t next = 0; next < points_mm_.size(); ++next) {
      if (used_[next]) continue;
      used_[next] = true;
      const Vec3 step_mm = points_mm_[next] - points_mm_[at];
      for (std::uint64_t n = 1; ticks + n + left - 1 < best_; ++n) {
        Speeds after;
        if (Reach(step_mm, n, speeds, after)) GoOn(next, after, ticks + n, left - 1);
      }
      used_[next] = false;
    }
  }

  bool Reach(const Vec3& step_mm, std::uint64_t ticks, const Speeds& before,
             Speeds& after) const {
    const double seconds = static_cast<double>(ticks) / options_.rate_hz;
    for (int axis = 0; axis < 3; ++axis) {
      const motion::AxisLimits limits{options_.limits.max_speed_mm_s[axis],
                                      options_.limits.max_acceleration_mm_s2[axis]};
      const SpeedInterval start = motion::Intersection(
          before[axis], motion::UsableStartSpeeds(step_mm[axis], seconds, limits));
      if (start.empty()) return false;
      after[axis] = motion::ReachableEndSpeeds(start, step_mm[axis], seconds, limits);
    }
    return true;
  }

  const PointList& points_mm_;
  const TicksBoundOptions& options_;
  std::vector<bool> used_;
  std::uint64_t best_ = 0;
};

std::uint64_t FewestPlannedTicks(const PointList& points_mm,
                                 const TicksBoundOptions& options) {
  Order order(points_mm.size());
  std::iota(order.begin(), order.end(), 0U);
  std::uint64_t fewest = ~std::uint64_t{0};
  do {
    fewest =
        std::min(fewest, PlannedTicks(points_mm, order, options.limits, options.rate_hz));
  } while (std::next_permutation(order.begin(), order.end()));
  return fewest;
}

/// A few points, of which a step takes from one tick to several.
PointList SmallCloud(std::mt19937& random, TicksBoundOptions& options) {
  std::uniform_real_distribution<double> unit(0, 1);
  for (int axis = 0; axis < 3; ++axis) {
    options.limits.max_speed_mm_s[axis] = 30 + 100 * unit(random);
    options.limits.max_acceleration_mm_s2[axis] = 2000 + 8000 * unit(random);
  }
  options.rate_hz = std::vector<double>{50, 100, 200, 500, 1000}[random() % 5];
  const double length_mm = 7000 / (options.rate_hz * options.rate_hz);
  const double size_mm = length_mm * std::pow(10, 1.5 * unit(random) - 0.7);
  PointList points_mm = RandomBox(3 + random() % 3, Vec3::Constant(size_mm), random());
  // Some are rows with a few points beside them, which are passed without a turn.
  if (random() % 2 == 0) {
    for (Vec3& p : points_mm) p.y() *= 0.1, p.z() *= 0.01;
  }
  return points_mm;
}

TEST(TicksBound, IsNeverAboveTheBestOfAllOrdersAndMotions) {
  std::mt19937 random(40);
  int reached = 0, more_than_one_a_step = 0;
  for (int i = 0; i < 1000; ++i) {
    TicksBoundOptions options;
    const PointList points_mm = SmallCloud(random, options);
    const std::uint64_t planned = FewestPlannedTicks(points_mm, options);
    const std::uint64_t best = EveryWay(points_mm, options).FewestTicks(planned);
    const std::uint64_t bound = TicksBound(points_mm, options);
    ASSERT_LE(bound, best) << "cloud " << i;
    ASSERT_GE(bound, points_mm.size() - 1) << "cloud " << i;
    reached += bound == best;
    more_than_one_a_step += bound > points_mm.size() - 1;
  }
  // It says something: more than that a step takes a tick, and often all there is.
  EXPECT_GT(more_than_one_a_step, 300);
  EXPECT_GT(reached, 100);
}

TEST(TicksBound, HoldsWhereverPointsAreMovedWithinTheTolerance) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> side(-1, 1);
  int lower = 0;
  for (int i = 0; i < 300; ++i) {
    TicksBoundOptions options;
    const PointList points_mm = SmallCloud(random, options);
    const std::uint64_t exact = TicksBound(points_mm, options);
    options.tolerance_mm = 0.05 * (points_mm[0] - points_mm[1]).norm();
    const std::uint64_t bound = TicksBound(points_mm, options);
    PointList moved_mm = points_mm;
    for (Vec3& p : moved_mm) {
      p += options.tolerance_mm *
           Vec3(side(random), side(random), side(random)).normalized();
    }
    const std::uint64_t planned = FewestPlannedTicks(moved_mm, options);
    ASSERT_LE(bound, EveryWay(moved_mm, options).FewestTicks(planned)) << "cloud " << i;
    ASSERT_LE(bound, exact);
    lower += bound < exact;
  }
  EXPECT_GT(lower, 0);
}

TEST(TicksBound, OfFewPoints) {
  const TicksBoundOptions options;
  EXPECT_EQ(TicksBound({}, options), 0u);
  EXPECT_EQ(TicksBound({Vec3(1, 2, 3)}, options), 0u);
  for (const auto& [name, points_mm] : DegenerateClouds()) {
    if (points_mm.size() < 2) continue;
    EXPECT_GE(TicksBound(points_mm, options), points_mm.size() - 1) << name;
  }
  EXPECT_EQ(TicksBound(PointList(300, Vec3(7, 8, 9)), options), 299u);
}

// 0.4 mm in a tick of 5 ms are 80 mm/s. A row is passed with a point in every tick; with
// an angle of 90 degrees in it two axes change their speed, but each no more than it may.
TEST(TicksBound, OfARowIsATickAStep) {
  TicksBoundOptions options;
  options.rate_hz = 200;
  EXPECT_EQ(TicksBound(Row(100, {0.39, 0, 0}), options), 99u);
  // Farther apart than the fastest tick goes, each step takes two: but for the ends.
  EXPECT_EQ(TicksBound(Row(100, {0.41, 0, 0}), options), 197u);
  options.tolerance_mm = 0.006;
  EXPECT_EQ(TicksBound(Row(100, {0.41, 0, 0}), options), 99u);
}

TEST(TicksBound, IsBelowTheOrderAndNearItOnAMeasuredCloud) {
  const PointList points_mm = FittedPoints("scatter");
  for (const double rate_hz : {100.0, 200.0}) {
    OrderOptions order;
    order.method = Method::kAnneal;
    order.cone = 0.1328;
    order.rate_hz = rate_hz;
    TicksBoundOptions options;
    options.rate_hz = rate_hz;
    const std::uint64_t bound = TicksBound(points_mm, options);
    const std::uint64_t ticks = PlannedTicks(
        points_mm, MakeOrder(points_mm, order).value(), order.limits, rate_hz);
    RecordProperty(std::to_string(rate_hz),
                   std::to_string(bound) + " " + std::to_string(ticks));
    EXPECT_LE(bound, ticks);
    EXPECT_GE(bound, points_mm.size() - 1);
    if (rate_hz == 100) {
      EXPECT_LE(static_cast<double>(ticks), 1.002 * static_cast<double>(bound));
    }
  }
}

TEST(TicksBound, DoesNotDependOnTheExecutor) {
  const PointList points_mm = DentedSphere(20000, 3);
  TicksBoundOptions options;
  options.rate_hz = 500;
  const std::uint64_t bound = TicksBound(points_mm, options);
  EXPECT_GT(bound, points_mm.size());
  for (const Executor& executor : Executors()) {
    options.executor = executor;
    EXPECT_EQ(TicksBound(points_mm, options), bound);
  }
}

TEST(TicksBound, RefusesWhatIsNoLimit) {
  TicksBoundOptions options;
  options.rate_hz = 0;
  EXPECT_THROW(TicksBound({}, options), PreconditionError);
  options = {};
  options.tolerance_mm = -1;
  EXPECT_THROW(TicksBound({}, options), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
