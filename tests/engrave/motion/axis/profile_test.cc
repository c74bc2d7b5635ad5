#include "engrave/motion/axis/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engrave/core/check.h"

namespace intaglio::motion {
namespace {

constexpr AxisLimits kPublishedLimits{80.0, 7000.0};

/// Distance covered by a course of accelerations, by summing over small times.
double Integrate(const std::function<double(double)>& acceleration, double duration_s,
                 double* peak_mm_s) {
  const int count = 200000;
  const double dt = duration_s / count;
  double speed = 0.0;
  double distance = 0.0;
  *peak_mm_s = 0.0;
  for (int k = 0; k < count; ++k) {
    const double a = acceleration((k + 0.5) * dt);
    distance += speed * dt + 0.5 * a * dt * dt;
    speed += a * dt;
    *peak_mm_s = std::max(*peak_mm_s, speed);
  }
  EXPECT_NEAR(speed, 0.0, 0.1);  // one step of the sum at the switch: a dt
  return distance;
}

TEST(Profile, TriangleCoversItsDistance) {
  for (const double s : {0.001, 0.09, 0.5, 0.9}) {
    const double t = TriangleSeconds(s, 7000.0);
    double peak = 0.0;
    const double covered =
        Integrate([&](double at) { return at < t / 2 ? 7000.0 : -7000.0; }, t, &peak);
    // The sum's switch may be half a step off: a T dt = 2e-5 of s.
    EXPECT_NEAR(covered, s, 4e-5 * s);
    EXPECT_NEAR(peak, 2 * s / t, 1e-4 * peak);
  }
}

TEST(Profile, TrapezoidCoversItsDistanceAndKeepsToTheSpeed) {
  for (const double s : {1.0, 2.0, 17.0, 100.0}) {
    const double t = TrapezoidSeconds(s, kPublishedLimits);
    const double ramp = SwitchingSeconds(t, s, 7000.0);
    EXPECT_NEAR(ramp, 80.0 / 7000.0, 1e-9);
    double peak = 0.0;
    const double covered = Integrate(
        [&](double at) { return at < ramp ? 7000.0 : (at > t - ramp ? -7000.0 : 0.0); },
        t, &peak);
    EXPECT_NEAR(covered, s, 1e-3 * s);  // the switch by one step: a t dt
    EXPECT_NEAR(peak, 80.0, 0.1);
  }
}

TEST(Profile, CubicIsHeldBackByTheNearerLimit) {
  const auto course = [](double s, double t) {
    return [s, t](double at) { return 6 * s / (t * t) * (1 - 2 * at / t); };
  };
  for (const double s : {0.09, 0.5, 3.0, 50.0}) {
    const double t = CubicSeconds(s, kPublishedLimits);
    double peak = 0.0;
    // The sum is exact but for dt^2: 1e-9.
    EXPECT_NEAR(Integrate(course(s, t), t, &peak), s, 1e-6 * s);
    const double peak_acceleration = 6 * s / (t * t);
    EXPECT_LE(peak, 80.0 * (1 + 1e-6));
    EXPECT_LE(peak_acceleration, 7000.0 * (1 + 1e-12));
    const bool at_a_limit = peak > 80.0 * (1 - 1e-6) || peak_acceleration > 6999.9999;
    EXPECT_TRUE(at_a_limit) << s;
  }
}

TEST(Profile, TriangleMeetsTrapezoidWhereTheSpeedIsReached) {
  const double s = 80.0 * 80.0 / 7000.0;  // sqrt(s a) = V
  EXPECT_NEAR(TriangleSeconds(s, 7000.0), TrapezoidSeconds(s, kPublishedLimits), 1e-15);
  EXPECT_EQ(StopAndGoSeconds(0.5 * s, kPublishedLimits),
            TriangleSeconds(0.5 * s, 7000.0));
  EXPECT_EQ(StopAndGoSeconds(2.0 * s, kPublishedLimits),
            TrapezoidSeconds(2.0 * s, kPublishedLimits));
  // At the triangle the ramp is half of the time.
  const double t = TriangleSeconds(s, 7000.0);
  EXPECT_NEAR(SwitchingSeconds(t, s, 7000.0), t / 2, 1e-9);
}

TEST(Profile, MixIsTheFastest) {
  for (double s = 1e-4; s < 100.0; s *= 1.3) {
    const double fastest = MinSeconds(Profile::kMix, s, kPublishedLimits);
    for (const Profile other :
         {Profile::kTriangle, Profile::kTrapezoid, Profile::kCubic}) {
      EXPECT_LE(fastest, MinSeconds(other, s, kPublishedLimits) * (1 + 1e-15));
    }
  }
}

/// The minimum time of a step whose axes follow one course.
double MinSecondsOf(const Vec3& step_mm, const Limits& limits) {
  return StopAndGoSeconds(1.0, UnitStepLimits(step_mm, limits));
}

TEST(Profile, EqualLimitsMakeTheLargestAxisDistanceCount) {
  EXPECT_NEAR(MinSecondsOf(Vec3(0.3, -2.5, 1.0), {}),
              StopAndGoSeconds(2.5, kPublishedLimits), 1e-15);
}

TEST(Profile, TheAxisNearestItsLimitGoverns) {
  const Limits limits{Vec3(80, 80, 10), Vec3(7000, 7000, 500)};
  // Alone, an axis is its own measure.
  EXPECT_NEAR(MinSecondsOf(Vec3(0, 0, -3), limits),
              StopAndGoSeconds(3.0, AxisLimits{10, 500}), 1e-15);
  // Together, never faster than the slowest alone.
  EXPECT_GE(MinSecondsOf(Vec3(2, 0, 0.01), limits), MinSecondsOf(Vec3(2, 0, 0), limits));
}

TEST(Profile, TicksAreWholeAndForgiveRounding) {
  EXPECT_EQ(WholeTicks(0.0, 100.0), 1u);
  EXPECT_EQ(WholeTicks(0.0099, 100.0), 1u);
  EXPECT_EQ(WholeTicks(0.0101, 100.0), 2u);
  EXPECT_EQ(WholeTicks(0.03 * (1 + 1e-10), 100.0), 3u);
  EXPECT_EQ(WholeTicks(0.03 * (1 + 1e-8), 100.0), 4u);
  EXPECT_THROW(WholeTicks(1e300, 100.0), PreconditionError);
}

TEST(Profile, UselessLimitsAreRefused) {
  Limits limits;
  limits.max_speed_mm_s.y() = 0.0;
  EXPECT_THROW(RequireUsable(limits), PreconditionError);
  limits = {};
  limits.max_acceleration_mm_s2.z() = std::nan("");
  EXPECT_THROW(RequireUsable(limits), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion
