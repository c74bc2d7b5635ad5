#include "engrave/motion/axis/jerk_reach.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace intaglio::motion {
namespace {

/// A course of pieces of constant jerk, by summing them.
struct Ride {
  double distance_mm = 0;
  double end_mm_s = 0;
  double end_acceleration_mm_s2 = 0;
  double peak_speed_mm_s = 0;
  double peak_acceleration_mm_s2 = 0;
};

struct Piece {
  double seconds, jerk_mm_s3;
};

Ride Follow(double start_mm_s, const std::vector<Piece>& pieces) {
  Ride ride{.end_mm_s = start_mm_s, .peak_speed_mm_s = std::abs(start_mm_s)};
  for (const auto& [t, j] : pieces) {
    double& v = ride.end_mm_s;
    double& a = ride.end_acceleration_mm_s2;
    if (j != 0 && -a / j > 0 && -a / j < t) {
      ride.peak_speed_mm_s =
          std::max(ride.peak_speed_mm_s, std::abs(v - 0.5 * a * a / j));
    }
    ride.distance_mm += t * (v + t * (0.5 * a + t * j / 6));
    v += t * (a + 0.5 * t * j);
    a += t * j;
    ride.peak_speed_mm_s = std::max(ride.peak_speed_mm_s, std::abs(v));
    ride.peak_acceleration_mm_s2 = std::max(ride.peak_acceleration_mm_s2, std::abs(a));
  }
  return ride;
}

void AddPulse(double gain_mm_s, double seconds, const JerkLimits& limits,
              std::vector<Piece>& pieces) {
  if (seconds <= 0) return;
  const double h = limits.max_acceleration_mm_s2 / limits.max_jerk_mm_s3;
  const double ramp = std::min(h, 0.5 * seconds);
  const double jerk = gain_mm_s / (ramp * (seconds - ramp));
  pieces.insert(pieces.end(), {{ramp, jerk}, {seconds - 2 * ramp, 0}, {ramp, -jerk}});
}

std::vector<Piece> PiecesOf(const Pulses& pulses, double start, double end,
                            double seconds, const JerkLimits& limits) {
  std::vector<Piece> pieces;
  AddPulse(pulses.cruise_mm_s - start, pulses.first_s, limits, pieces);
  pieces.push_back({seconds - pulses.first_s - pulses.last_s, 0});
  AddPulse(end - pulses.cruise_mm_s, pulses.last_s, limits, pieces);
  return pieces;
}

struct Case {
  JerkLimits limits;
  double seconds, start, end, distance;
};

Case RandomCase(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Case c;
  c.seconds = std::pow(10.0, -2 + unit(random));
  c.limits = {80, 7000, 7000 / (c.seconds * std::pow(10.0, unit(random)))};
  c.start = 80 * unit(random);
  c.end = 80 * unit(random);
  c.distance = 80 * c.seconds * unit(random) * 0.999;
  return c;
}

TEST(GentlestPulses, GoTheWayInTheTimeWithinTheSpeedAndTheirShare) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto [limits, seconds, start, end, distance] = RandomCase(random);
    const Pulses pulses = GentlestPulses(start, end, distance, seconds, limits);
    ASSERT_GE(pulses.first_s, 0);
    ASSERT_GE(pulses.last_s, 0);
    ASSERT_LE(pulses.first_s + pulses.last_s, seconds * (1 + 1e-9));
    const auto pieces = PiecesOf(pulses, start, end, seconds, limits);
    const Ride ride = Follow(start, pieces);
    EXPECT_NEAR(ride.distance_mm, distance, 1e-9 * 80 * seconds);
    EXPECT_NEAR(ride.end_mm_s, end, 1e-9);
    EXPECT_LE(ride.peak_speed_mm_s, 80 * (1 + 1e-9));
    EXPECT_LE(ride.peak_acceleration_mm_s2, pulses.share * 7000 * (1 + 1e-6) + 1e-6);
    for (const Piece& piece : pieces) {
      EXPECT_LE(std::abs(piece.jerk_mm_s3),
                pulses.share * limits.max_jerk_mm_s3 * (1 + 1e-6) + 1e-3);
    }
  }
}

TEST(HardestPulses, GoTheWayInTheTimeAndTurnBackSoonest) {
  std::mt19937_64 random(2);
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto [limits, seconds, start, end, distance] = RandomCase(random);
    const Pulses gentle = GentlestPulses(start, end, distance, seconds, limits);
    if (gentle.share > 1) continue;
    const Pulses hard = HardestPulses(start, end, distance, seconds, limits);
    const auto pieces = PiecesOf(hard, start, end, seconds, limits);
    const Ride ride = Follow(start, pieces);
    EXPECT_NEAR(ride.distance_mm, distance, 1e-9 * 80 * seconds);
    EXPECT_NEAR(ride.end_mm_s, end, 1e-9);
    EXPECT_GT(hard.share, 0.5);
    ++count;
  }
  EXPECT_GT(count, 1000);
}

// All courses of eight equal pieces with jerk -J, 0 or J and acceleration 0 at the ends:
// none may reach a speed that the intervals exclude, and for the fastest and slowest ends
// of the intervals there is a course within the limits.
TEST(ReachableEndSpeedsWithJerk, HoldEveryCourseOfAGrid) {
  constexpr int kPieces = 8, kCourses = 6561;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int within = 0, near = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Case c = RandomCase(random);
    for (int code = 0; code < kCourses; ++code) {
      std::vector<Piece> pieces;
      int sum = 0;
      for (int k = 0, digits = code; k < kPieces; ++k, digits /= 3) {
        sum += digits % 3 - 1;
        pieces.push_back(
            {c.seconds / kPieces, (digits % 3 - 1) * c.limits.max_jerk_mm_s3});
      }
      const Ride ride = Follow(c.start, pieces);
      if (sum != 0 || ride.peak_speed_mm_s > 80 || ride.peak_acceleration_mm_s2 > 7000) {
        continue;
      }
      const SpeedInterval usable =
          UsableStartSpeeds(ride.distance_mm, c.seconds, c.limits);
      ASSERT_LE(usable.lo, c.start + 1e-9);
      ASSERT_GE(usable.hi, c.start - 1e-9);
      const SpeedInterval end =
          ReachableEndSpeeds({c.start, c.start}, ride.distance_mm, c.seconds, c.limits);
      ASSERT_LE(end.lo, ride.end_mm_s + 1e-9);
      ASSERT_GE(end.hi, ride.end_mm_s - 1e-9);
      ++within;
      near += end.hi - ride.end_mm_s < 0.05 * c.seconds * 7000 ? 1 : 0;
    }
  }
  EXPECT_GT(within, 2000);
  EXPECT_GT(near, 200);
}

TEST(ReachableEndSpeedsWithJerk, TheirEndsAreReached) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  int usable_count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Case c = RandomCase(random);
    const double a = 80 * unit(random);
    const SpeedInterval start =
        Intersection({std::min(a, c.start), std::max(a, c.start)},
                     UsableStartSpeeds(c.distance, c.seconds, c.limits));
    if (start.empty()) continue;
    ++usable_count;
    const SpeedInterval end = ReachableEndSpeeds(start, c.distance, c.seconds, c.limits);
    const auto share = [&](double from, double to) {
      return GentlestPulses(from, to, c.distance, c.seconds, c.limits).share;
    };
    EXPECT_LE(share(start.lo, end.hi), 1 + 1e-6);
    EXPECT_LE(share(start.hi, end.lo), 1 + 1e-6);
    // A little further is not, but for a speed limit.
    EXPECT_TRUE(end.hi > 80 - 1e-3 || share(start.lo, end.hi + 1e-3) > 1);
    EXPECT_TRUE(end.lo < -80 + 1e-3 || share(start.hi, end.lo - 1e-3) > 1);
  }
  EXPECT_GT(usable_count, 2000);
}

// Without a jerk that is felt it is axis_reach.h.
TEST(ReachableEndSpeedsWithJerk, TendToThoseWithout) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 5000; ++i) {
    Case c = RandomCase(random);
    c.limits.max_jerk_mm_s3 = 1e14;
    const AxisLimits free{80, 7000};
    const SpeedInterval usable = UsableStartSpeeds(c.distance, c.seconds, free);
    const SpeedInterval with = UsableStartSpeeds(c.distance, c.seconds, c.limits);
    EXPECT_NEAR(with.lo, usable.lo, 1e-3);
    EXPECT_NEAR(with.hi, usable.hi, 1e-3);
    const SpeedInterval start = Intersection({c.start, c.start}, with);
    if (start.empty() || !usable.Contains(c.start)) continue;
    EXPECT_NEAR(ReachableEndSpeeds(start, c.distance, c.seconds, c.limits).hi,
                ReachableEndSpeeds(start, c.distance, c.seconds, free).hi, 0.05);
  }
}

TEST(PulseSpeedWithin, IsBrakedWithinTheDistance) {
  for (const double jerk : {1e4, 1e6, 1e8}) {
    const JerkLimits limits{80, 7000, jerk};
    for (const double distance : {0.0, 1e-4, 0.1, 30.0}) {
      const double speed = PulseSpeedWithin(distance, limits);
      EXPECT_NEAR(0.5 * speed * PulseSeconds(speed, limits), distance, 1e-9);
    }
  }
}

}  // namespace
}  // namespace intaglio::motion
