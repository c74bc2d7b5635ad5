#include "engrave/motion/segments/segment.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/engrave/motion/hermite_velocity.h"

namespace intaglio::motion {
namespace {

struct Sample {
  KnotState from;
  Segment to;
  double duration_s = 1.0;
};

Sample RandomSample(std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-50.0, 50.0);
  std::uniform_real_distribution<double> speed(-80.0, 80.0);
  std::uniform_real_distribution<double> time(0.001, 2.0);
  Sample sample;
  for (int axis = 0; axis < 3; ++axis) {
    sample.from.position_mm[axis] = place(random);
    sample.from.velocity_mm_s[axis] = speed(random);
    sample.to.end_position_mm[axis] = place(random);
    sample.to.end_velocity_mm_s[axis] = speed(random);
  }
  sample.duration_s = time(random);
  return sample;
}

TEST(Segment, ReachesItsEndStates) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    const auto [from, to, d] = RandomSample(random);
    // Rounding: values up to 50 mm, and up to 3e5 mm/s^2 times short durations.
    EXPECT_LT((HermitePosition(from, to, 0.0, d) - from.position_mm).norm(), 1e-12);
    EXPECT_LT((HermitePosition(from, to, d, d) - to.end_position_mm).norm(), 1e-12);
    EXPECT_LT((HermiteVelocity(from, to, 0.0, d) - from.velocity_mm_s).norm(), 1e-12);
    EXPECT_LT((HermiteVelocity(from, to, d, d) - to.end_velocity_mm_s).norm(), 1e-8);
  }
}

TEST(Segment, DerivativesAgreeWithDifferences) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const auto [from, to, d] = RandomSample(random);
    const double t = 0.37 * d;
    const double h = 1e-3 * d;
    // Central differences of a cubic: the error is jerk h^2 / 6 for the first, none
    // for the others; 1e-6 of the scale covers it and the rounding of /h.
    const Vec3 jerk = HermiteJerk(from, to, d);
    const Vec3 velocity =
        (HermitePosition(from, to, t + h, d) - HermitePosition(from, to, t - h, d)) /
        (2 * h);
    EXPECT_LT((velocity - jerk * h * h / 6 - HermiteVelocity(from, to, t, d)).norm(),
              1e-8 / d);
    const Vec3 acceleration =
        (HermiteVelocity(from, to, t + h, d) - HermiteVelocity(from, to, t - h, d)) /
        (2 * h);
    EXPECT_LT((acceleration - HermiteAcceleration(from, to, t, d)).norm(),
              1e-8 / (d * d));
    const Vec3 jerk_difference = (HermiteAcceleration(from, to, t + h, d) -
                                  HermiteAcceleration(from, to, t - h, d)) /
                                 (2 * h);
    EXPECT_LT((jerk_difference - jerk).norm(), 1e-6 / (d * d * d));
  }
}

TEST(Segment, ExtremesAgreeWithDenseSampling) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const auto [from, to, d] = RandomSample(random);
    Vec3 speed = Vec3::Zero();
    Vec3 acceleration = Vec3::Zero();
    const int count = 2000;
    for (int k = 0; k <= count; ++k) {
      const double t = d * k / count;
      speed = speed.cwiseMax(HermiteVelocity(from, to, t, d).cwiseAbs());
      acceleration =
          acceleration.cwiseMax(HermiteAcceleration(from, to, t, d).cwiseAbs());
    }
    const Vec3 speed_limit = MaxSpeed(from, to, d);
    const Vec3 acceleration_limit = MaxAcceleration(from, to, d);
    // The vertex of the speed lies at most half a sample step from a sample, where the
    // parabola has fallen by jerk (d / 4000)^2 / 2.
    const Vec3 fall = HermiteJerk(from, to, d).cwiseAbs() * (d / 4000) * (d / 4000) / 2;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(speed_limit[axis], speed[axis] * (1 - 1e-12));
      EXPECT_LE(speed_limit[axis], speed[axis] * (1 + 1e-12) + fall[axis]);
      EXPECT_NEAR(acceleration_limit[axis], acceleration[axis],
                  1e-12 * acceleration[axis]);
    }
  }
}

TEST(Segment, ConstantAccelerationHasNoJerk) {
  const double d = 0.5;
  const Vec3 a(100.0, -40.0, 7.0);
  Segment to;
  to.end_position_mm = 0.5 * a * d * d;
  to.end_velocity_mm_s = a * d;
  EXPECT_LT(HermiteJerk({}, to, d).norm(), 1e-10);
  EXPECT_LT((MaxAcceleration({}, to, d) - a.cwiseAbs()).norm(), 1e-10);
  EXPECT_LT((MaxSpeed({}, to, d) - a.cwiseAbs() * d).norm(), 1e-10);
}

TEST(Segment, SubticksAreExactOverLongJobs) {
  EXPECT_EQ(DurationSeconds(std::uint64_t{kSubticksPerTick} * 4000, 4000.0), 1.0);
  EXPECT_LE(std::uint64_t{kMaxSegmentTicks} * kSubticksPerTick, 0xFFFFFFFFu);
}

}  // namespace
}  // namespace intaglio::motion
