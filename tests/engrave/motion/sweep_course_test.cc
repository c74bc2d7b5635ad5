#include "engrave/motion/sweep_course.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engrave/core/check.h"

namespace intaglio::motion::sweep_course_test {
namespace {

struct Tube {
  SweepStart start;
  std::vector<double> targets_mm, seconds;
  double tolerance_mm = 0;
};

/// Heights in slabs from the lowest on, in any order within a slab, steps of 1 to 4
/// ticks.
Tube RandomSlabs(std::size_t count, std::size_t per_slab, double slab_mm,
                 std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Tube of;
  of.tolerance_mm = slab_mm;
  for (std::size_t i = 0; i < count; ++i) {
    const auto slab = static_cast<double>(i / per_slab);
    of.targets_mm.push_back(slab_mm * (slab + unit(random)));
    of.seconds.push_back(2.5e-4 * std::ceil(4 * unit(random)));
  }
  return of;
}

std::vector<double> Solved(const Tube& of, bool to_last = false) {
  std::vector<double> places_mm;
  SweepCourse().Solve(of.start, of.targets_mm, of.seconds, of.tolerance_mm, 1000, to_last,
                      places_mm);
  return places_mm;
}

/// The integral of the squared acceleration, by the velocities of the steps.
double BendingOf(const Tube& of, const std::vector<double>& places_mm) {
  double sum = 0, before_mm_s = of.start.speed_mm_s, before_s = 0;
  double at_mm = of.start.position_mm;
  for (std::size_t i = 0; i < places_mm.size(); ++i) {
    const double speed = (places_mm[i] - at_mm) / of.seconds[i];
    sum += std::pow(speed - before_mm_s, 2) / (0.5 * (before_s + of.seconds[i]));
    before_mm_s = speed;
    before_s = of.seconds[i];
    at_mm = places_mm[i];
  }
  return sum;
}

/// Least bending by another way: coordinate descent from the middles, each place at its
/// best of three probes of a parabola, until nothing moves.
std::vector<double> Descended(const Tube& of) {
  std::vector<double> places_mm = of.targets_mm;
  const double probe_mm = 0.1 * of.tolerance_mm;
  for (int sweep = 0; sweep < 20000; ++sweep) {
    for (std::size_t i = 0; i < places_mm.size(); ++i) {
      const double here_mm = places_mm[i];
      const auto cost = [&](double away_mm) {
        places_mm[i] = here_mm + away_mm;
        return BendingOf(of, places_mm);
      };
      const double below = cost(-probe_mm), at = cost(0), above = cost(probe_mm);
      const double move_mm = 0.5 * probe_mm * (below - above) / (below - 2 * at + above);
      places_mm[i] = std::clamp(here_mm + move_mm, of.targets_mm[i] - of.tolerance_mm,
                                of.targets_mm[i] + of.tolerance_mm);
    }
  }
  return places_mm;
}

TEST(SweepCourse, NoPlaceIsFartherThanTheToleranceFromItsTarget) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Tube of = RandomSlabs(300, 1 + seed, 0.05, seed);
    of.tolerance_mm = 0.002 * static_cast<double>(seed);
    of.start = {of.targets_mm.front() + 0.3, 5};
    const auto places_mm = Solved(of, seed % 2 == 0);
    ASSERT_EQ(places_mm.size(), of.targets_mm.size());
    for (std::size_t i = 0; i < places_mm.size(); ++i) {
      ASSERT_LE(std::abs(places_mm[i] - of.targets_mm[i]),
                of.tolerance_mm * (1 + 1e-12) + 1e-14)
          << seed << ", place " << i;
    }
    if (seed % 2 == 0) {
      EXPECT_EQ(places_mm.back(), of.targets_mm.back());
    }
  }
}

TEST(SweepCourse, GoesStraightWhereAStraightLineIsInTheTube) {
  Tube of = RandomSlabs(400, 20, 0.05, 3);
  // By time, so that the line through the tube is at constant speed.
  double time_s = 0;
  for (std::size_t i = 0; i < of.targets_mm.size(); ++i) {
    time_s += of.seconds[i];
    of.targets_mm[i] = 2 * time_s + (i % 2 == 0 ? 0.03 : -0.03);
  }
  of.start = {0, 2};
  EXPECT_LT(BendingOf(of, Solved(of)), 1e-6 * BendingOf(of, of.targets_mm));
}

// Oracle: the descent, which needs thousands of passes. A tube that is narrower by 3 % on
// each side has a least bending that is greater by some per cent.
TEST(SweepCourse, BendsHardlyMoreThanItHasTo) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Tube of = RandomSlabs(24, 4, 0.05, seed);
    of.start = {of.targets_mm.front(), 0.5};
    const double minimum = BendingOf(of, Descended(of));
    EXPECT_LT(BendingOf(of, Solved(of)), 1.25 * minimum + 1e-9) << seed;
    EXPECT_GT(BendingOf(of, Solved(of)), 0.99 * minimum) << seed;
  }
}

TEST(SweepCourse, KeepsItsTargetsWithoutATolerance) {
  Tube of = RandomSlabs(50, 5, 0.05, 1);
  of.tolerance_mm = 0;
  EXPECT_EQ(Solved(of), of.targets_mm);
  of.targets_mm.clear();
  of.seconds.clear();
  EXPECT_TRUE(Solved(of).empty());
}

TEST(SweepCourse, RefusesWhatIsNoTube) {
  Tube of = RandomSlabs(5, 5, 0.05, 1);
  of.tolerance_mm = -1;
  EXPECT_THROW(Solved(of), PreconditionError);
  of.tolerance_mm = 1;
  of.seconds.pop_back();
  EXPECT_THROW(Solved(of), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion::sweep_course_test
