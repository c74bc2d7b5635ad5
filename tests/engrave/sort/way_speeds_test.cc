#include "engrave/sort/near/way_speeds.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "engrave/motion/tick_planner.h"
#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort {
namespace {

/// A way at the least number of ticks that the motion planner finds for each step.
struct PlannedWay {
  PlannedWay(const PointList& points_mm, const TickCost& cost,
             const motion::Limits& limits, double rate_hz) {
    motion::TickPlanner planner(limits, rate_hz, motion::OptionsForRate(rate_hz),
                                {points_mm[0], Vec3::Zero()});
    std::vector<motion::Segment> segments;
    for (std::size_t i = 1; i < points_mm.size(); ++i)
      planner.Append(points_mm[i], static_cast<std::int32_t>(i), true, segments);
    planner.Finish(segments);
    moves.push_back({});
    std::uint32_t subticks = 0;
    for (const motion::Segment& segment : segments) {
      subticks += segment.duration_subticks;
      if (!segment.pulse) continue;
      const std::size_t i = moves.size();
      moves.push_back({cost.Scale(points_mm[i] - points_mm[i - 1]),
                       static_cast<float>(subticks) / motion::kSubticksPerTick});
      velocities.push_back(cost.Scale(segment.end_velocity_mm_s / rate_hz));
      subticks = 0;
    }
  }

  auto MoveTo() const {
    return [this](std::size_t place) { return moves[place]; };
  }

  std::vector<TimedMove> moves;    ///< to each place, the first of no meaning
  std::vector<Scaled> velocities;  ///< at each place but the first, in A T
};

bool Contains(const SpeedBox& box, const Scaled& velocity) {
  const float speeds[] = {velocity.x, velocity.y, velocity.z};
  for (int i = 0; i < 3; ++i) {
    const auto [lo, hi] = motion::IntervalOf(box.axis[i]);
    const double rounding = 1e-4 * (1 + std::abs(speeds[i]));
    if (speeds[i] < lo - rounding || speeds[i] > hi + rounding) return false;
  }
  return true;
}

TEST(WaySpeeds, HaveThoseOfThePlannedMotion) {
  for (const double rate_hz : {100.0, 200.0, 1000.0}) {
    const PointList points_mm = RandomBox(400, {3, 3, 3}, 4);
    const motion::Limits limits;
    const TickCost cost(limits, rate_hz);
    const PlannedWay way(points_mm, cost, limits, rate_hz);
    ASSERT_EQ(way.moves.size(), points_mm.size());
    WaySpeeds speeds(cost);
    ASSERT_TRUE(speeds.Begin(points_mm.size(), way.MoveTo())) << rate_hz;
    for (std::size_t i = 1; i < points_mm.size(); ++i) {
      ASSERT_TRUE(Contains(speeds.Past(i), way.velocities[i - 1])) << i;
      ASSERT_TRUE(Contains(speeds.Future(i), way.velocities[i - 1])) << i;
      ASSERT_TRUE(speeds.Past(i).Meets(speeds.Future(i))) << i;
    }
  }
}

// The planner's ticks are the fewest but for the labels it gives up, so that hardly a
// step can be made in one less while the others keep theirs.
TEST(WaySpeeds, LeaveHardlyAStepInLessTicksThanPlanned) {
  const PointList points_mm = RandomBox(400, {3, 3, 3}, 4);
  const motion::Limits limits;
  const TickCost cost(limits, 200);
  PlannedWay way(points_mm, cost, limits, 200);
  WaySpeeds speeds(cost);
  int possible = 0, tried = 0;
  for (std::size_t i = 2; i + 2 < points_mm.size(); ++i) {
    if (way.moves[i].ticks <= cost.MinTicks(way.moves[i].step)) continue;
    way.moves[i].ticks -= 1;
    ++tried;
    if (speeds.Begin(points_mm.size(), way.MoveTo())) ++possible;
    way.moves[i].ticks += 1;
  }
  EXPECT_GT(tried, 200);
  EXPECT_LE(possible, 2);
}

TEST(WaySpeeds, SettleToWhatTheyAreWhenBegunAnew) {
  std::mt19937_64 random(1);
  const PointList points_mm = RandomBox(300, {3, 3, 3}, 4);
  const motion::Limits limits;
  const TickCost cost(limits, 200);
  PlannedWay way(points_mm, cost, limits, 200);
  WaySpeeds settled(cost), begun(cost);
  ASSERT_TRUE(settled.Begin(points_mm.size(), way.MoveTo()));
  for (int round = 0; round < 300; ++round) {
    const std::size_t first = 1 + random() % (points_mm.size() - 4);
    const std::size_t last = first + random() % 3;
    const WaySpeeds::Steps changed{first, last};
    const std::vector<TimedMove> before = way.moves;
    for (std::size_t i = first; i <= last; ++i)
      way.moves[i].ticks += static_cast<float>(random() % 2);
    const bool can = settled.Settle({&changed, 1}, way.MoveTo());
    ASSERT_EQ(can, begun.Begin(points_mm.size(), way.MoveTo())) << round;
    if (!can) {
      way.moves = before;
      ASSERT_TRUE(settled.Begin(points_mm.size(), way.MoveTo()));
      continue;
    }
    for (std::size_t i = 0; i < points_mm.size(); ++i) {
      ASSERT_TRUE(settled.Past(i).IsNear(begun.Past(i))) << round << ", " << i;
      ASSERT_TRUE(settled.Future(i).IsNear(begun.Future(i))) << round << ", " << i;
    }
  }
}

TEST(WaySpeeds, OfTheWayBackAreReversed) {
  const PointList points_mm = RandomBox(100, {3, 3, 3}, 4);
  const motion::Limits limits;
  const TickCost cost(limits, 200);
  const PlannedWay way(points_mm, cost, limits, 200);
  WaySpeeds there(cost), back(cost);
  const std::size_t size = points_mm.size();
  ASSERT_TRUE(there.Begin(size, way.MoveTo()));
  ASSERT_TRUE(back.Begin(size, [&](std::size_t place) {
    const TimedMove& move = way.moves[size - place];
    return TimedMove{Scaled{} - move.step, move.ticks};
  }));
  for (std::size_t i = 0; i < size; ++i) {
    EXPECT_TRUE(back.Past(i).IsNear(there.Future(size - 1 - i).Reversed())) << i;
    EXPECT_TRUE(back.Future(i).IsNear(there.Past(size - 1 - i).Reversed())) << i;
  }
}

TEST(WaySpeeds, FindNoneForASpeedBeyondTheLimit) {
  const motion::Limits limits;
  const TickCost cost(limits, 100);
  WaySpeeds speeds(cost);
  const TimedMove slow{cost.Scale({0.79, 0, 0}), 1}, fast{cost.Scale({0.81, 0, 0}), 1};
  EXPECT_TRUE(speeds.Begin(2, [&](std::size_t) { return slow; }));
  EXPECT_FALSE(speeds.Begin(2, [&](std::size_t) { return fast; }));
}

}  // namespace
}  // namespace intaglio::sort
