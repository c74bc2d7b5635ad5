#include "engrave/course/tracking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/course/axis_filter.h"
#include "engrave/course/kernel_figures.h"
#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

// Exact stepping against Runge-Kutta, with the same straight line between setpoints.
TEST(AxisFilter, SolvesTheLoops) {
  for (const LoopKind loop : {LoopKind::kFirstOrder, LoopKind::kCascade}) {
    const AxisPair axes = TunedAxes(150, 220, 0.3, 0.2, loop);
    for (const double period_s : {0.0005, 0.003}) {
      std::vector<Vec2> setpoints;
      std::vector<double> x, actual(400);
      for (int i = 0; i < 400; ++i) {
        setpoints.push_back({std::sin(0.03 * i) + (i > 200 ? 1 : 0), 0});
        x.push_back(setpoints.back().x());
      }
      AxisFilter(axes[0].product(), period_s).Run(x, actual);
      const auto oracle = OracleFollow(OracleOf(axes), setpoints, period_s, 1);
      for (std::size_t i = 0; i < actual.size(); ++i)
        ASSERT_NEAR(actual[i], oracle[i].x(), 2e-5) << i;  // Runge-Kutta of .1 ms
    }
  }
}

TEST(AxisFilter, BeginsSettled) {
  const AxisPair axes = TunedAxes(150, 220, 0.3, 0.2);
  std::vector<double> ramp(100), actual(100);
  for (std::size_t i = 0; i < ramp.size(); ++i)
    ramp[i] = 5 + 0.1 * static_cast<double>(i);
  AxisFilter(axes[1].product(), 0.001).Run(ramp, actual);
  for (std::size_t i = 0; i < ramp.size(); ++i)
    ASSERT_NEAR(actual[i], ramp[i] - axes[1].lag_s() * 100, 1e-9);
}

TEST(SplineKernel, IsSymmetricAndKeepsStraightMotion) {
  const SplineKernel kernel = SplineKernel::Of(0.022, 3, 0.0005);
  EXPECT_EQ(kernel.box % 2, 1);
  EXPECT_LE(kernel.length_s(), 0.022 + 1e-12);
  const auto weights = kernel.Weights();
  ASSERT_EQ(weights.size(), 2 * kernel.half_count() + 1);
  std::vector<double> line(200), bent(200);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i] = 3 + 0.25 * static_cast<double>(i);
    bent[i] = std::abs(static_cast<double>(i) - 100);
  }
  const auto kept = Smoothed(kernel, line), smooth = Smoothed(kernel, bent);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_NEAR(kept[i], line[i + kernel.half_count()], 1e-10);
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * bent[i + k];
    ASSERT_NEAR(smooth[i], sum, 1e-10);
  }
}

// The rounding of a corner: 2 v sin(turn / 2) m.
TEST(SplineKernel, RoundsACornerByItsHalfMean) {
  const AxisPair axes = TunedAxes(150, 220, 0.3, 0.3);
  const Tracking tracking(axes, {0.00025, 0, 0.022});
  const Path corner = CornerPath(0.4, 1.2, 20, 50);
  const SpeedLaw law = PlanSpeeds(corner, std::vector<double>{50}, 5000);
  const Tracked tracked = tracking.Follow(corner, law, axes, Exactness::kModel, false);
  double nearest = 1e9;
  for (const Vec2& p : tracked.actual_mm) nearest = std::min(nearest, p.norm());
  const KernelFigures figures = FiguresOf(tracking.kernel(), axes);
  EXPECT_NEAR(nearest, 2 * 50 * std::sin(0.6) * figures.rounding_s, 2e-4);
}

// The axes, solved step by step, are where the smoothed reference is: without lag, both
// alike; also through a cascade and with setpoints every millisecond.
TEST(Tracking, CompensatedAxesAreOnTheSmoothedReference) {
  for (const LoopKind loop : {LoopKind::kFirstOrder, LoopKind::kCascade}) {
    const AxisPair axes = TunedAxes(150, 220, 0.3, 0.3, loop);
    for (const double period_s : {0.0005, 0.001}) {
      const Tracking tracking(axes, {period_s, 0, 0.03});
      const Path corner = CornerPath(0.3, 1.5, 15, 60);
      const SpeedLaw law = PlanSpeeds(corner, std::vector<double>{30}, 3000);
      const Tracked model = tracking.Follow(corner, law, axes, Exactness::kModel, false);
      const Tracked real = tracking.Follow(corner, law, axes, Exactness::kAxes, false);
      const auto oracle = OracleFollow(OracleOf(axes), real.setpoints_mm, period_s, 1);
      double worst = 0;
      for (std::size_t i = 0; i < model.actual_mm.size(); ++i) {
        worst = std::max(worst, (model.actual_mm[i] - oracle[i]).norm());
        ASSERT_NEAR((real.actual_mm[i] - oracle[i]).norm(), 0, 1e-4);
      }
      // Straight lines between setpoints, in place of the smooth command: its second
      // derivative times period^2 / 12, and it grows with the square of the period.
      EXPECT_LT(worst, (loop == LoopKind::kCascade ? 0.008 : 0.004) * period_s / 0.0005)
          << (loop == LoopKind::kCascade ? "cascade " : "first order ") << period_s;
    }
  }
}

void ExpectSame(const std::vector<double>& part, const std::vector<double>& whole,
                std::size_t first, double slack) {
  for (std::size_t i = 0; i < part.size(); ++i)
    ASSERT_NEAR(part[i], whole[first + i], slack) << i;
}

// Whatever part is followed by itself, begin, middle or end.
TEST(Tracking, APartIsWhatItIsInTheWhole) {
  const AxisPair axes = MeasuredMachine();
  const Path path = CutProgram(0.3, 100, 80, {0, 0, 0, 1}).front();
  const SpeedLaw law =
      PlanSpeeds(path, std::vector<double>(path.node_count() - 2, 20), 3000);
  for (const TrackingOptions& options :
       {TrackingOptions{0.0005, 0, {}}, TrackingOptions{0.0005, 0.01, {}},
        TrackingOptions{0.0005, 0, 0.022}}) {
    const Tracking tracking(axes, options);
    for (const Exactness exactness : {Exactness::kModel, Exactness::kAxes}) {
      const Tracked whole = tracking.Follow(path, law, axes, exactness, true);
      const Instants instants = tracking.InstantsOf(law, axes, exactness);
      ASSERT_EQ(instants.count, whole.actual_mm.size());
      for (const Part part :
           {Part{0, 100}, Part{1500, 1900}, Part{instants.count - 50, instants.count}}) {
        const Tracked own =
            tracking.FollowPart(path, law, axes, exactness, true, true, instants, part);
        ASSERT_EQ(own.actual_mm.size(), part.end - part.begin);
        EXPECT_NEAR(own.first_s, whole.first_s + 0.0005 * static_cast<double>(part.begin),
                    1e-12);
        for (std::size_t i = 0; i < own.actual_mm.size(); ++i)
          ASSERT_NEAR((own.actual_mm[i] - whole.actual_mm[part.begin + i]).norm(), 0,
                      1e-8);
        ExpectSame(own.commanded_s_mm, whole.commanded_s_mm, part.begin, 1e-9);
        // Derivatives of values that are rounded.
        ExpectSame(own.motor_mm_s2, whole.motor_mm_s2, part.begin, 1);
        ExpectSame(own.jerk_mm_s3, whole.jerk_mm_s3, part.begin, 1000);
      }
    }
  }
}

// The load on a circle at constant speed has v^2 / R, and the motor more by the
// mechanics' gain at that rate.
TEST(Tracking, ReportsTheMotorsAcceleration) {
  const AxisPair axes = TunedAxes(150, 150, 0.3, 0.3);
  const double radius = 10, v = 80, rate = v / radius;
  std::vector<Piece> pieces;
  for (int i = 1; i <= 8; ++i) {
    const double angle = std::numbers::pi / 2 * i;
    pieces.push_back(
        {radius * Vec2(std::cos(angle), std::sin(angle)), v, std::numbers::pi / 2});
  }
  const Path circles = Path::Make(Vec2(radius, 0), pieces).value();
  const Tracking tracking(axes, {0.0005, 0, 0.02});
  std::vector<double> nodes(circles.node_count() - 2, v);
  const SpeedLaw law = PlanSpeeds(circles, nodes, 2000);
  const Tracked tracked = tracking.Follow(circles, law, axes, Exactness::kAxes, true);
  const double gain =
      std::abs(std::complex<double>(1 - rate * rate / 150 / 150, 0.6 * rate / 150));
  double greatest = 0;
  // Away from the ends, where the law accelerates.
  for (std::size_t i = 0; i < tracked.motor_mm_s2.size(); ++i) {
    const double s = tracked.commanded_s_mm[i];
    if (s > 20 && s < circles.length_mm() - 20)
      greatest = std::max(greatest, tracked.motor_mm_s2[i]);
  }
  EXPECT_NEAR(greatest, gain * v * v / radius, 0.01 * v * v / radius);
}

}  // namespace
}  // namespace intaglio::course
