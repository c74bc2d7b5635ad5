// The published machine: 53 measured times of one job (Trochimczuk 2008 annex F) at
// 50 and 100 Hz, 80 and 100 mm/s, 2..10 m/s^2, against our count of ticks.
// tests/bench/published_tables prints them all.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engrave/motion/paths.h"
#include "tests/engrave/motion/published_steps.h"
#include "tests/engrave/motion/published_tables.h"

namespace intaglio::motion {
namespace {

TEST(PublishedTimings, StopAndGoReproducesAllOfThem) {
  const PointList job = FittedPoints("calibrated_ordered");
  const auto times = MeasuredTimes();
  ASSERT_EQ(job.size(), 16179u);
  ASSERT_EQ(times.size(), 53u);
  double square_s2 = 0.0;
  for (const MeasuredTime& row : times) {
    const double ours_s = ModelSeconds(job, LimitsOf(row), row.rate_hz);
    // The table is rounded to 1 s.
    EXPECT_NEAR(ours_s, row.time_s, 1.0)
        << row.rate_hz << " Hz, " << row.speed_mm_s << " mm/s, " << row.acceleration_mm_s2
        << " mm/s^2";
    square_s2 += (ours_s - row.time_s) * (ours_s - row.time_s);
  }
  // Rounding to 1 s alone gives 0.29 s rms.
  const double rms_s = std::sqrt(square_s2 / static_cast<double>(times.size()));
  EXPECT_LT(rms_s, 0.35);
  RecordProperty("rms_s", std::to_string(rms_s));
}

// The published spacing of f = 43 mm is 0.09 mm, of f = 70 mm 0.13 mm. tests/bench/
// published_steps prints all models.
TEST(PublishedTimings, NoStepsAtThePublishedSpacingExplainThemWithAStopAtEachPoint) {
  const auto rows = MeasuredTimes();
  const StepFit fit = FitSteps({}, 0.09, rows);
  EXPECT_GT(fit.rms_s, 25);
  EXPECT_GT(fit.largest_s, 80);
  // What makes each step longer explains them less.
  EXPECT_GT(FitSteps({.settling_s = 0.001}, 0.09, rows).rms_s, fit.rms_s);
  EXPECT_NEAR(FitSteps({.cycle_s = 0.0002}, 0.09, rows).rms_s, fit.rms_s, 0.1);
  EXPECT_GT(FitSteps({.whole_ticks = false}, 0.09, rows).largest_s, 10);
  // With steps of any length it is the model of StopAndGoReproducesAllOfThem.
  EXPECT_LT(FitSteps({}, 0.02, rows).rms_s, 0.35);
}

TEST(PublishedTimings, AWindowAboutThePointExplainsThemAtThePublishedSpacing) {
  const auto rows = MeasuredTimes();
  const StepFit fit = FitSteps({.window_mm = 0.015}, 0.09, rows);
  EXPECT_LT(fit.rms_s, 0.35);
  EXPECT_LT(fit.largest_s, 1);
  EXPECT_LT(FitSteps({.window_mm = 0.040}, 0.13, rows).largest_s, 1);
  // The source reproduces points within 50 um.
  EXPECT_LT(FitSteps({.window_mm = 0.050, .settling_s = 0.0005}, 0.13, rows).largest_s,
            1);
  // No narrower one does.
  EXPECT_GT(FitSteps({.window_mm = 0.010}, 0.09, rows).largest_s, 50);
  EXPECT_GT(FitSteps({.window_mm = 0.030}, 0.13, rows).largest_s, 50);
}

// The times of a fit summed up by the planner of the product, which stops at each point.
TEST(PublishedTimings, TheModelOfAStepIsThePlanners) {
  for (const MeasuredTime& row : MeasuredTimes()) {
    for (const double mm : {0.03, 0.09, 0.4, 3.0, 14.0}) {
      EXPECT_DOUBLE_EQ(
          SecondsOf({}, mm, row),
          static_cast<double>(StopAndGoTicks({Vec3(mm, 0.2 * mm, 0)}, Vec3::Zero(),
                                             LimitsOf(row), row.rate_hz, Profile::kMix)) /
              row.rate_hz);
    }
  }
}

}  // namespace
}  // namespace intaglio::motion
