#include "engrave/motion/lq_program.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/axis/profile.h"
#include "engrave/motion/axis/program_options.h"
#include "engrave/motion/verify.h"

namespace intaglio::motion {
namespace {

constexpr double kLqRateHz = 100.0;

struct LqStep {
  std::uint64_t ticks = 0;
  std::vector<Segment> segments;
};

LqStep Drive(const Vec3& to_mm, const Limits& limits, double rate_hz = kLqRateHz) {
  LqStep step;
  step.ticks = LqProgram(limits, rate_hz).Append(Vec3::Zero(), to_mm, step.segments);
  return step;
}

/// Share of the way done at t of the closed form: the integral of its speed over the
/// whole.
double ClosedForm(double t, double duration, double w) {
  const double z = w * duration / 2;
  // In exponentials of -z, as cosh(z) overflows on long steps.
  const auto speed = [&](double at) {
    const double y = w * (duration / 2 - at);
    return 1 + std::exp(-2 * z) - std::exp(y - z) - std::exp(-y - z);
  };
  const int count = 2000;  // Simpson
  const auto integral = [&](double until) {
    double sum = speed(0) + speed(until);
    for (int i = 1; i < count; ++i) sum += (i % 2 ? 4 : 2) * speed(until * i / count);
    return sum * until / count / 3;
  };
  return integral(t) / integral(duration);
}

TEST(LqProgram, FollowsTheClosedForm) {
  for (const double way_mm : {0.05, 0.5, 3.0, 20.0}) {
    const LqStep step = Drive(Vec3(way_mm, 0, 0), {});
    const double duration = static_cast<double>(step.ticks) / kLqRateHz;
    double t = 0.0;
    for (const Segment& segment : step.segments) {
      t += DurationSeconds(segment.duration_subticks, kLqRateHz);
      // There are 2 stages in 1 / w.
      EXPECT_NEAR(segment.end_position_mm.x() / way_mm,
                  ClosedForm(t, duration, 7000.0 / 80.0), 0.01)
          << way_mm;
    }
  }
}

TEST(LqProgram, AShortStepIsNearlyTheCubic) {
  // 1 / w is 11 ms; the step takes 1.
  const Limits limits;
  const LqStep step = Drive(Vec3(1e-3, 0, 0), limits, 1000.0);
  ASSERT_EQ(step.ticks, 1u);
  double u = 0.0;
  for (const Segment& segment : step.segments) {
    u += segment.duration_subticks / static_cast<double>(kSubticksPerTick);
    // Held accelerations: of N stages a share of 1 / N^2 of the way.
    EXPECT_NEAR(segment.end_position_mm.x(), 1e-3 * u * u * (3 - 2 * u), 0.01e-3);
  }
}

TEST(LqProgram, ALongStepCruises) {
  const Limits limits;
  const LqStep step = Drive(Vec3(60, 0, 0), limits);
  // s / V + 2 V / a = 772.9 ms.
  EXPECT_EQ(step.ticks, 78u);
  double top = 0.0;
  for (const Segment& segment : step.segments) {
    top = std::max(top, segment.end_velocity_mm_s.x());
  }
  EXPECT_GT(top, 79.0);
  EXPECT_LE(top, 80.0 * (1 + 1e-9));
}

TEST(LqProgram, TakesNoTickMoreThanItMust) {
  // One tick less passes a limit by the closed form, whose speed peaks in the middle and
  // whose acceleration at the ends.
  const AxisLimits axis{80.0, 7000.0};
  const double w = 7000.0 / 80.0;
  for (double way_mm = 0.01; way_mm < 60; way_mm *= 1.3) {
    const LqStep step = Drive(Vec3(way_mm, 0, 0), {});
    EXPECT_GE(step.ticks, WholeTicks(StopAndGoSeconds(way_mm, axis), kLqRateHz));
    if (step.ticks == 1) continue;
    const double duration = static_cast<double>(step.ticks - 1) / kLqRateHz;
    const double z = w * duration / 2;
    const double scale = way_mm / (duration * std::cosh(z) - 2 / w * std::sinh(z));
    const double speed_ratio = scale * (std::cosh(z) - 1) / 80.0;
    const double acceleration_ratio = scale * w * std::sinh(z) / 7000.0;
    // Held accelerations are below that of the form's end, so what passes the limit held
    // passes it the more there; the speeds differ by less than 1 %.
    EXPECT_GT(std::max(speed_ratio * 1.01, acceleration_ratio), 1.0) << way_mm;
  }
}

TEST(LqProgram, IsStraightAndItsEndNeedsNoMending) {
  const Limits limits;
  for (const double rate_hz : {50.0, 4000.0}) {
    for (const Vec3& way : {Vec3(0.01, -0.02, 0), Vec3(3, 1, -2), Vec3(200, 10, 30)}) {
      const LqStep step = Drive(way, limits, rate_hz);
      for (const Segment& segment : step.segments) {
        EXPECT_LT(segment.end_position_mm.cross(way).norm(), 1e-12 * way.squaredNorm());
      }
      // The last piece goes to the exact end with the acceleration of the first.
      const auto acceleration = [&](const KnotState& from, const Segment& to) {
        return MaxAcceleration(from, to, DurationSeconds(to.duration_subticks, rate_hz));
      };
      const std::size_t count = step.segments.size();
      const Vec3 first = acceleration({}, step.segments[0]);
      const Vec3 last =
          acceleration(step.segments[count - 2].end(), step.segments.back());
      EXPECT_LT((first - last).norm(), 1e-6 * first.norm());
    }
  }
}

TEST(LqProgram, APlantsRateIsThatOfItsClosedForm) {
  // w^2 = (q / r) beta^2 + alpha^2 in SI and mm: beta 1000 / 2, alpha -10 / 2.
  EXPECT_NEAR(LqRatePerS({2, 10, 0, 1}), 5, 1e-12);
  EXPECT_NEAR(LqRatePerS({2, 0, 9e-4, 4}), 7.5, 1e-12);
  EXPECT_NEAR(LqRatePerS({2, 10, 9e-4, 4}), std::hypot(5, 7.5), 1e-12);
  EXPECT_THROW(LqRatePerS({0, 10, 1, 1}), PreconditionError);
  EXPECT_THROW(LqRatePerS({1, -1, 1, 1}), PreconditionError);

  const double w_per_s = LqRatePerS({1, 200, 0, 1});
  std::vector<Segment> segments;
  const auto ticks =
      LqProgram({}, kLqRateHz, w_per_s).Append(Vec3::Zero(), Vec3(20, 0, 0), segments);
  const double duration = static_cast<double>(ticks) / kLqRateHz;
  double t = 0;
  for (const Segment& segment : segments) {
    t += DurationSeconds(segment.duration_subticks, kLqRateHz);
    // There are 2 stages in 1 / w, as above.
    EXPECT_NEAR(segment.end_position_mm.x() / 20, ClosedForm(t, duration, w_per_s), 0.01);
  }
}

TEST(LqProgram, WithoutWeightAndFrictionIsTheCubic) {
  std::vector<Segment> segments;
  LqProgram({}, kLqRateHz, LqRatePerS({})).Append(Vec3::Zero(), Vec3(9, 0, 0), segments);
  double total = 0;
  for (const Segment& s : segments) total += s.duration_subticks;
  double u = 0;
  for (const Segment& segment : segments) {
    u += segment.duration_subticks / total;
    // Held accelerations: of 8 stages 1 / 64 of the way at most.
    EXPECT_NEAR(segment.end_position_mm.x(), 9 * u * u * (3 - 2 * u), 9.0 / 64);
  }
}

}  // namespace
}  // namespace intaglio::motion
