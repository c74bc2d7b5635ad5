#include "engrave/motion/axis/axis_reach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace intaglio::motion {
namespace {

constexpr AxisLimits kLimits{80, 7000};

/// Where `arcs` ends, by summing the three arcs, and how fast it went.
struct ArcsRide {
  double distance_mm = 0;
  double peak_speed_mm_s = 0;
  double peak_acceleration_mm_s2 = 0;
};

ArcsRide Follow(const Arcs& arcs, double start, double end, double seconds) {
  ArcsRide ride;
  const double cruise_s = seconds - arcs.first_s - arcs.last_s;
  ride.distance_mm = 0.5 * (start + arcs.cruise_mm_s) * arcs.first_s +
                     arcs.cruise_mm_s * cruise_s +
                     0.5 * (arcs.cruise_mm_s + end) * arcs.last_s;
  ride.peak_speed_mm_s =
      std::max({std::abs(start), std::abs(end), std::abs(arcs.cruise_mm_s)});
  if (arcs.first_s > 0) {
    ride.peak_acceleration_mm_s2 = std::abs(arcs.cruise_mm_s - start) / arcs.first_s;
  }
  if (arcs.last_s > 0) {
    ride.peak_acceleration_mm_s2 = std::max(
        ride.peak_acceleration_mm_s2, std::abs(end - arcs.cruise_mm_s) / arcs.last_s);
  }
  return ride;
}

struct AskedStep {
  double start, end, distance, seconds;
};

AskedStep RandomStep(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const double seconds = std::pow(10.0, -2.5 + unit(random));
  return {80 * unit(random), 80 * unit(random), 80 * seconds * unit(random) * 0.999,
          seconds};
}

TEST(GentlestArcs, GoTheWayInTheTimeWithinTheSpeed) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const AskedStep s = RandomStep(random);
    const Arcs arcs = GentlestArcs(s.start, s.end, s.distance, s.seconds, 80);
    ASSERT_GE(arcs.first_s, 0);
    ASSERT_GE(arcs.last_s, 0);
    ASSERT_LE(arcs.first_s + arcs.last_s, s.seconds * (1 + 1e-12));
    const ArcsRide ride = Follow(arcs, s.start, s.end, s.seconds);
    EXPECT_NEAR(ride.distance_mm, s.distance, 1e-11);
    EXPECT_LE(ride.peak_speed_mm_s, 80 * (1 + 1e-12));
    EXPECT_LE(ride.peak_acceleration_mm_s2, arcs.peak_acceleration_mm_s2 * (1 + 1e-6));
  }
}

// Every course has a peak acceleration at least that of the gentlest: here courses of
// 16 arcs, their accelerations drawn at random and their end taken as the question.
TEST(GentlestArcs, NoRandomCourseIsGentler) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double seconds = 0.01, start = 80 * unit(random);
    double speed = start, distance = 0, peak = 0, top = std::abs(start);
    for (int arc = 0; arc < 16; ++arc) {
      const double acceleration = 7000 * unit(random);
      const double next = speed + acceleration * seconds / 16;
      distance += 0.5 * (speed + next) * seconds / 16;
      speed = next;
      peak = std::max(peak, std::abs(acceleration));
      top = std::max(top, std::abs(speed));
    }
    const Arcs arcs = GentlestArcs(start, speed, distance, seconds, top);
    EXPECT_LE(arcs.peak_acceleration_mm_s2, peak * (1 + 1e-9));
  }
}

// Where it turns back, it is as far beyond its ends as full braking takes it.
TEST(HardestArcs, GoTheWayInTheTimeAndTurnBackAtFullAcceleration) {
  std::mt19937_64 random(5);
  int feasible = 0, turning = 0;
  for (int i = 0; i < 20000; ++i) {
    const AskedStep s = RandomStep(random);
    const Arcs gentle = GentlestArcs(s.start, s.end, s.distance, s.seconds, 80);
    if (gentle.peak_acceleration_mm_s2 > 7000) continue;
    ++feasible;
    const Arcs arcs = HardestArcs(s.start, s.end, s.distance, s.seconds, kLimits);
    ASSERT_LE(arcs.first_s + arcs.last_s, s.seconds * (1 + 1e-9));
    const ArcsRide ride = Follow(arcs, s.start, s.end, s.seconds);
    EXPECT_NEAR(ride.distance_mm, s.distance, 1e-9);
    EXPECT_LE(ride.peak_speed_mm_s, 80 * (1 + 1e-9));
    EXPECT_LE(ride.peak_acceleration_mm_s2, 7000 * (1 + 1e-6));
    if (s.start > 1 && arcs.cruise_mm_s < -1) {
      ++turning;
      EXPECT_NEAR((s.start - arcs.cruise_mm_s) / arcs.first_s, 7000, 1e-3);
    }
  }
  EXPECT_GT(feasible, 1000);
  EXPECT_GT(turning, 100);
}

bool Feasible(double start, double end, double distance, double seconds) {
  return GentlestArcs(start, end, distance, seconds, 80).peak_acceleration_mm_s2 <= 7000;
}

// The interval by its formulas against the gentlest course on a fine grid.
TEST(ReachableEndSpeeds, AreThoseWithAFeasibleCourse) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int usable_count = 0;
  for (int i = 0; i < 400; ++i) {
    const AskedStep s = RandomStep(random);
    const double a = 80 * unit(random), b = 80 * unit(random);
    const SpeedInterval start =
        Intersection({std::min(a, b), std::max(a, b)},
                     UsableStartSpeeds(s.distance, s.seconds, kLimits));
    double lo = INFINITY, hi = -INFINITY;
    constexpr int kGrid = 100;
    for (int from = 0; from <= kGrid; ++from) {
      const double v = std::min(a, b) + std::abs(a - b) * from / kGrid;
      for (int to = 0; to <= kGrid; ++to) {
        const double w = -80 + 160.0 * to / kGrid;
        if (!Feasible(v, w, s.distance, s.seconds)) continue;
        lo = std::min(lo, w);
        hi = std::max(hi, w);
      }
    }
    if (start.empty()) {
      EXPECT_EQ(lo, INFINITY);
      continue;
    }
    ++usable_count;
    const SpeedInterval end = ReachableEndSpeeds(start, s.distance, s.seconds, kLimits);
    // Nothing outside, and the ends themselves are reached.
    EXPECT_GE(lo, end.lo - 1e-9);
    EXPECT_LE(hi, end.hi + 1e-9);
    const auto reached = [&](double from, double to) {
      return GentlestArcs(from, to, s.distance, s.seconds, 80).peak_acceleration_mm_s2;
    };
    EXPECT_LE(reached(start.lo, end.hi), 7000 * (1 + 1e-6));
    EXPECT_LE(reached(start.hi, end.lo), 7000 * (1 + 1e-6));
  }
  EXPECT_GT(usable_count, 200);
}

TEST(ReachableEndSpeeds, ServesBackwardsToo) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 2000; ++i) {
    const AskedStep s = RandomStep(random);
    const SpeedInterval end{s.end, s.end};
    if (Intersection(end, UsableStartSpeeds(s.distance, s.seconds, kLimits)).empty()) {
      EXPECT_GT(
          GentlestArcs(s.start, s.end, s.distance, s.seconds, 80).peak_acceleration_mm_s2,
          7000);
      continue;
    }
    const SpeedInterval start = ReachableEndSpeeds(end, s.distance, s.seconds, kLimits);
    EXPECT_EQ(start.Contains(s.start), Feasible(s.start, s.end, s.distance, s.seconds));
  }
}

TEST(UsableStartSpeeds, AStepTooLongHasNone) {
  EXPECT_TRUE(UsableStartSpeeds(0.81, 0.01, kLimits).empty());
  EXPECT_TRUE(UsableStartSpeeds(-0.81, 0.01, kLimits).empty());
  EXPECT_FALSE(UsableStartSpeeds(0.79, 0.01, kLimits).empty());
}

}  // namespace
}  // namespace intaglio::motion
