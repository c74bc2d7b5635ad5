#include "engrave/sort/near/tick_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/motion/axis/axis_reach.h"

namespace intaglio::sort {
namespace {

/// A step in mm and the ticks it is made in.
struct Step {
  Vec3 mm;
  double ticks;
};

/// A stage and a lamp, drawn at random.
struct Machine {
  motion::Limits limits;
  double rate_hz = 100;

  explicit Machine(std::mt19937_64& random) {
    std::uniform_real_distribution<double> unit(0, 1);
    rate_hz = std::round(50 * std::pow(80.0, unit(random)));
    for (int axis = 0; axis < 3; ++axis) {
      limits.max_speed_mm_s[axis] = 20 * std::pow(10.0, unit(random));
      limits.max_acceleration_mm_s2[axis] = 500 * std::pow(20.0, unit(random));
    }
  }

  double SpeedMmS(const Step& step, int axis) const {
    return step.mm[axis] / step.ticks * rate_hz;
  }

  /// The definition, in mm and s.
  double Bend(const Step& a, const Step& b) const {
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double change_mm_s = std::abs(SpeedMmS(b, axis) - SpeedMmS(a, axis));
      const double seconds = 0.5 * (a.ticks + b.ticks) / rate_hz;
      largest =
          std::max(largest, change_mm_s / seconds / limits.max_acceleration_mm_s2[axis]);
    }
    return largest;
  }

  /// What single precision may do to Bend: its velocities are rounded twice.
  double Rounding(const Step& a, const Step& b) const {
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double per_tick_mm_s = limits.max_acceleration_mm_s2[axis] / rate_hz;
      largest = std::max({largest, std::abs(SpeedMmS(a, axis)) / per_tick_mm_s,
                          std::abs(SpeedMmS(b, axis)) / per_tick_mm_s});
    }
    return 1e-6 +
           8 * std::numeric_limits<float>::epsilon() * largest / (a.ticks + b.ticks);
  }

  /// Whether one step can follow the other from whatever speed before them.
  bool IsPossible(const Step& a, const Step& b) const {
    for (int axis = 0; axis < 3; ++axis) {
      const motion::AxisLimits axis_limits = motion::LimitsOf(limits, axis);
      const double a_s = a.ticks / rate_hz;
      const auto start = motion::UsableStartSpeeds(a.mm[axis], a_s, axis_limits);
      if (start.empty()) return false;
      const auto between = motion::Intersection(
          motion::ReachableEndSpeeds(start, a.mm[axis], a_s, axis_limits),
          motion::UsableStartSpeeds(b.mm[axis], b.ticks / rate_hz, axis_limits));
      if (between.empty()) return false;
    }
    return true;
  }

  /// Up to `share` of the maximum that the speed allows, each axis differently.
  Step RandomStep(std::mt19937_64& random, double ticks, double share) const {
    std::uniform_real_distribution<double> either(-1, 1);
    Step step{Vec3::Zero(), ticks};
    for (int axis = 0; axis < 3; ++axis) {
      step.mm[axis] =
          share * either(random) * limits.max_speed_mm_s[axis] * ticks / rate_hz;
    }
    return step;
  }

  TimedMove Timed(const TickCost& cost, const Step& step) const {
    return {cost.Scale(step.mm), static_cast<float>(step.ticks)};
  }
};

double RandomTicks(std::mt19937_64& random) {
  return 1 + static_cast<double>(random() % (random() % 2 == 0 ? 2 : 12));
}

TEST(TickCost, BendIsTheShareOfTheAccelerationLimit) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const Machine machine(random);
    const TickCost cost(machine.limits, machine.rate_hz);
    const Step a = machine.RandomStep(random, RandomTicks(random), 1);
    const Step b = machine.RandomStep(random, RandomTicks(random), 1);
    const double bend = TickCost::Bend(machine.Timed(cost, a), machine.Timed(cost, b));
    const double expected = machine.Bend(a, b);
    ASSERT_NEAR(bend, expected, 1e-6 * expected + machine.Rounding(a, b));
  }
}

// Bend accepts everything that the exact intervals of speeds accept.
TEST(TickCost, BendWithinOneIsNecessary) {
  std::mt19937_64 random(2);
  int possible = 0;
  double largest = 0;
  for (int i = 0; i < 100000; ++i) {
    const Machine machine(random);
    const TickCost cost(machine.limits, machine.rate_hz);
    Step a = machine.RandomStep(random, RandomTicks(random), 0.999);
    Step b = machine.RandomStep(random, RandomTicks(random), 0.999);
    // Shorter until it is just possible, where a bound too tight would show.
    for (int halvings = 0; halvings < 12 && !machine.IsPossible(a, b); ++halvings) {
      a.mm *= 0.8;
      b.mm *= 0.8;
    }
    if (!machine.IsPossible(a, b)) continue;
    ++possible;
    const double bend = TickCost::Bend(machine.Timed(cost, a), machine.Timed(cost, b));
    ASSERT_LE(bend, 1 + machine.Rounding(a, b));
    largest = std::max(largest, bend);
  }
  EXPECT_GT(possible, 50000);
  EXPECT_GT(largest, 0.99) << "the bound is not needlessly wide";
}

TEST(TickCost, MinTicksKeepTheSpeedLimits) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const Machine machine(random);
    const TickCost cost(machine.limits, machine.rate_hz);
    const Step step = machine.RandomStep(random, 1, 60 * unit(random));
    const double fastest =
        (step.mm.cwiseAbs().cwiseQuotient(machine.limits.max_speed_mm_s)).maxCoeff() *
        machine.rate_hz;
    const double smallest = cost.MinTicks(cost.Scale(step.mm));
    ASSERT_EQ(smallest, std::round(smallest));
    ASSERT_GE(smallest, std::max(1.0, fastest * (1 - 3e-6)));
    ASSERT_LT(smallest, std::max(1.0, fastest) * (1 + 1e-6) + 1);
  }
  EXPECT_EQ(TickCost({}, 100).MinTicks({}), 1) << "no step takes a tick as well";
}

TEST(TickCost, TicksAfterAreTheFewestWithinTheLimit) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  int longer = 0;
  for (int i = 0; i < 50000; ++i) {
    const Machine machine(random);
    const TickCost cost(machine.limits, machine.rate_hz);
    const Step before = machine.RandomStep(random, RandomTicks(random), unit(random));
    Step step = machine.RandomStep(random, 1, std::pow(30.0, unit(random)) - 1);
    // Straight on, at times, where fewer ticks may do than in the other direction.
    if (i % 2 == 0) step.mm = before.mm * (10 * unit(random));
    const TimedMove timed = machine.Timed(cost, before);
    const Scaled scaled = cost.Scale(step.mm);
    const double chosen = cost.TicksAfter(timed, scaled);
    step.ticks = chosen;
    const double smallest = cost.MinTicks(scaled);
    ASSERT_GE(chosen, smallest);
    ASSERT_LE(machine.Bend(before, step), 1 + machine.Rounding(before, step));
    for (step.ticks = smallest; step.ticks < chosen; ++step.ticks) {
      ASSERT_GT(machine.Bend(before, step), 1 - machine.Rounding(before, step))
          << step.ticks << " ticks would do instead of " << chosen;
    }
    if (chosen > smallest) ++longer;
  }
  EXPECT_GT(longer, 10000);
}

// The choices that tick_cost.cc names.
std::vector<float> Beyond(double rate_hz) {
  if (rate_hz <= 250) return {0, 1, 2, 3};
  return {0, 1, 2, 3, 4, 7, 12, 19};
}

/// The minimum sum of ticks and bends over all choices, by enumeration.
double Cheapest(const TickCost& cost, const std::vector<float>& beyond,
                std::vector<TimedMove>& moves, std::size_t next) {
  if (next + 1 == moves.size()) {
    double sum = 0;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      if (i + 1 < moves.size()) sum += moves[i].ticks;
      sum += cost.BendCost(TickCost::Bend(moves[i - 1], moves[i]));
    }
    return sum;
  }
  double smallest = std::numeric_limits<double>::infinity();
  const float fewest = cost.MinTicks(moves[next].step);
  for (const float more : beyond) {
    moves[next].ticks = fewest + more;
    smallest = std::min(smallest, Cheapest(cost, beyond, moves, next + 1));
  }
  return smallest;
}

/// With what the best has above the fewest ticks it is found; with less, all that comes
/// is that it costs more.
void ExpectSpareDecides(const TickCost& cost, const std::vector<TimedMove>& moves,
                        const std::vector<Scaled>& steps, double best, double tolerance) {
  double fewest = 0;
  for (const Scaled& step : steps) fewest += cost.MinTicks(step);
  const double excess = best - fewest;
  float ticks[TickCost::kMaxSteps] = {};
  const auto found = [&](double spare) {
    return cost.BestTicks(moves.front(), steps, moves.back(), ticks,
                          static_cast<float>(spare));
  };
  EXPECT_NEAR(found(excess + 2 * tolerance), best, tolerance);
  EXPECT_NEAR(found(3 * excess + 1), best, tolerance);
  for (const double share : {0.0, 0.3, 0.9}) {
    const double spare = share * excess - 2 * tolerance;
    if (spare < 0) continue;
    EXPECT_GT(found(spare), fewest + spare);
  }
}

TEST(TickCost, BestTicksAreTheCheapestOfAllChoices) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 400; ++i) {
    const Machine machine(random);
    const TickCost cost(machine.limits, machine.rate_hz);
    const std::vector<float> beyond = Beyond(machine.rate_hz);
    const std::size_t count = 1 + random() % (beyond.size() > 4 ? 3 : 4);
    std::vector<TimedMove> moves;
    for (std::size_t k = 0; k < count + 2; ++k) {
      // Steps that can mostly be made, and some that need many ticks.
      const double ticks = RandomTicks(random);
      moves.push_back(
          machine.Timed(cost, machine.RandomStep(random, ticks, k % 3 == 0 ? 0.8 : 0.2)));
    }
    std::vector<Scaled> steps;
    for (std::size_t k = 1; k <= count; ++k) steps.push_back(moves[k].step);
    float ticks[TickCost::kMaxSteps] = {};
    const double best = cost.BestTicks(moves.front(), steps, moves.back(), ticks);
    std::vector<TimedMove> chosen;
    for (std::size_t k = 0; k < count; ++k) chosen.push_back({steps[k], ticks[k]});
    // Single precision of sums up to some thousand.
    const double tolerance = 1e-6 * best + 1e-5;
    EXPECT_NEAR(cost.CostOf(moves.front(), chosen, moves.back()), best, tolerance);
    EXPECT_NEAR(Cheapest(cost, beyond, moves, 1), best, tolerance);
    ExpectSpareDecides(cost, moves, steps, best, tolerance);
  }
}

TEST(TickCost, BendsPastTheLimitCostMoreThanAnyDetour) {
  const TickCost cost({}, 100);
  EXPECT_EQ(cost.BendCost(0), 0);
  EXPECT_GT(cost.BendCost(1.0001F), 900);
  for (float bend = 0; bend < 3; bend += 0.01F) {
    EXPECT_LE(cost.BendCost(bend), cost.BendCost(bend + 0.01F));
  }
}

TEST(TickCost, BendsCostMoreWhereOnlyNeighboursFit) {
  const TickCost of_way({}, 100, Fit::kWay), of_neighbours({}, 100, Fit::kNeighbours);
  EXPECT_GT(of_way.BendCost(1), 0.1);
  EXPECT_GT(of_neighbours.BendCost(1), 2 * of_way.BendCost(1));
}

TEST(TickCost, StopAndGoIsTheTriangleOfTheSlowestAxis) {
  motion::Limits limits;
  limits.max_acceleration_mm_s2 = {8000, 2000, 5000};
  // From rest to rest over s at acceleration a: 2 sqrt(s / a).
  EXPECT_DOUBLE_EQ(TickCost(limits, 500).StopAndGoTicks(0.2), 500 * 2 * 0.01);
}

// Far beyond what single precision counts in ones.
TEST(TickCost, TicksAfterEndsWithMoreTicksThanCanBeCounted) {
  motion::Limits limits;
  limits.max_acceleration_mm_s2 = Vec3::Constant(0.001);
  const TickCost cost(limits, 4000);
  for (const double mm : {1e-3, 1.0, 1e3, 1e6, 1e9}) {
    const Scaled step = cost.Scale({mm, -mm, mm});
    const TimedMove before{step, cost.MinTicks(step)};
    const Scaled next = cost.Scale({0, 0.1, 0});
    // A relative 1e-6 for ticks that are rounded themselves.
    EXPECT_LE(TickCost::Bend(before, {next, cost.TicksAfter(before, next)}), 1 + 1e-6);
    EXPECT_LE(TickCost::Bend({}, {step, cost.TicksAfter({}, step)}), 1 + 1e-6);
  }
}

TEST(TickCost, WrongArgumentsThrow) {
  EXPECT_THROW(TickCost({}, 0), PreconditionError);
  EXPECT_THROW(TickCost({}, std::nan("")), PreconditionError);
  motion::Limits limits;
  limits.max_speed_mm_s.y() = 0;
  EXPECT_THROW(TickCost(limits, 100), PreconditionError);
  const TickCost cost({}, 100);
  float ticks[TickCost::kMaxSteps + 1];
  EXPECT_THROW(cost.BestTicks({}, {}, {}, ticks), PreconditionError);
  const std::vector<Scaled> many(TickCost::kMaxSteps + 1);
  EXPECT_THROW(cost.BestTicks({}, many, {}, ticks), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
