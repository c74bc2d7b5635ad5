// What the source says of its throughput in sentences and in annex G (Trochimczuk 2008
// ch. 6.3, annex G), against the model that reproduces its tables, each with the
// assumption under which it holds; the source names none.

#include <gtest/gtest.h>

#include <array>

#include "tests/engrave/motion/paths.h"
#include "tests/engrave/motion/published_tables.h"

namespace intaglio::motion {
namespace {

Limits LimitsAt(double acceleration_mm_s2) {
  return {.max_speed_mm_s = Vec3::Constant(80),
          .max_acceleration_mm_s2 = Vec3::Constant(acceleration_mm_s2)};
}

double MeasuredSeconds(double rate_hz, double acceleration_mm_s2) {
  for (const MeasuredTime& row : MeasuredTimes()) {
    if (row.rate_hz == rate_hz && row.speed_mm_s == 80 &&
        row.acceleration_mm_s2 == acceleration_mm_s2) {
      return row.time_s;
    }
  }
  ADD_FAILURE() << "no row of " << rate_hz << " Hz and " << acceleration_mm_s2;
  return 0;
}

TEST(PublishedClaims, TheFourJobsOfAnnexGTakeTheirTimes) {
  // Assumption: 100 Hz, 80 mm/s and 10 m/s^2, the fastest row of annex F, and steps that
  // are distributed as those of its object, for the four models are not published.
  struct Job {
    double point_count, seconds;
  };
  constexpr std::array kJobs = {Job{13196, 144}, Job{15777, 172}, Job{175305, 1906},
                                Job{21997, 239}};
  const PointList object = FittedPoints("calibrated_ordered");
  const double per_point_s =
      ModelSeconds(object, LimitsAt(10000), 100) / static_cast<double>(object.size());
  for (const Job& job : kJobs) {
    // Other objects have other steps: the four differ by 0.4 % among each other.
    EXPECT_NEAR(job.point_count * per_point_s / job.seconds, 1, 0.015) << job.point_count;
  }
  // No slower row of annex F explains them: 9 m/s^2 is 2 % too slow for the last two.
  const double slower_s =
      ModelSeconds(object, LimitsAt(9000), 100) / static_cast<double>(object.size());
  EXPECT_GT(175305 * slower_s / 1906, 1.02);
}

TEST(PublishedClaims, ALaserOf100HzGives82PercentMore) {
  // Assumption: each laser at the acceleration that its tables recommend, 7.5 m/s^2 for
  // 50 Hz and 9 for 100 Hz; at equal accelerations the tables give 29 to 74 %.
  EXPECT_NEAR(MeasuredSeconds(50, 7500) / MeasuredSeconds(100, 9000), 1.82, 0.01);
  const PointList object = FittedPoints("calibrated_ordered");
  EXPECT_NEAR(ModelSeconds(object, LimitsAt(7500), 50) /
                  ModelSeconds(object, LimitsAt(9000), 100),
              1.82, 0.015);
}

TEST(PublishedClaims, SplinesGive47PercentMoreByTheAccelerationTheyAllow) {
  // Assumption: splines do not shake the machine, so that it runs at 7 m/s^2 instead
  // of 2. At one acceleration a cubic step is slower than the triangle, by sqrt(6) to 2.
  double best_s = 0;  // the best sorting angle at 7 m/s^2
  for (const MeasuredAngle& row : MeasuredAngles()) {
    if (best_s == 0 || row.time_s < best_s) best_s = row.time_s;
  }
  EXPECT_NEAR(MeasuredSeconds(100, 2000) / best_s, 1.47, 0.01);
  const PointList object = FittedPoints("calibrated_ordered");
  // The order of the tables is not the best one: 195 s for 192 s.
  EXPECT_NEAR(ModelSeconds(object, LimitsAt(2000), 100) /
                  ModelSeconds(object, LimitsAt(7000), 100),
              1.47, 0.03);
}

}  // namespace
}  // namespace intaglio::motion
