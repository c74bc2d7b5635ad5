// The published machine: 53 measured times of one job (Trochimczuk 2008 annex F) at
// 50 and 100 Hz, 80 and 100 mm/s, 2..10 m/s^2, against our count of ticks.
// tests/bench/published_tables prints them all.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engrave/motion/paths.h"
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

}  // namespace
}  // namespace intaglio::motion
