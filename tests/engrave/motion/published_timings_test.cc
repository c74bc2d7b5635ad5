// The published machine: 53 measured times of one job (Trochimczuk 2008 annex F) at
// 50 and 100 Hz, 80 and 100 mm/s, 2..10 m/s^2, against our count of ticks.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "engrave/motion/stop_and_go.h"

namespace intaglio::motion {
namespace {

const std::string kMeasured = INTAGLIO_SOURCE_DIR "/../shared/data/";

PointList ReadJob(const std::string& path) {
  PointList points;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    Vec3 point;
    if (fields >> point.x() >> point.y() >> point.z()) points.push_back(point);
  }
  return points;
}

TEST(PublishedTimings, StopAndGoReproducesAllOfThem) {
  const PointList job = ReadJob(kMeasured + "jobs/calibrated_ordered.xyz");
  std::ifstream table(kMeasured + "els03_timings.csv");
  if (job.empty() || !table) GTEST_SKIP() << "no measured tables beside the sources";
  ASSERT_EQ(job.size(), 16179u);

  int rows = 0;
  double square_s2 = 0.0;
  for (std::string line; std::getline(table, line);) {
    double rate_hz, speed_m_s, acceleration_m_s2, measured_s;
    char comma;
    std::istringstream fields(line);
    if (!(fields >> rate_hz >> comma >> speed_m_s >> comma >> acceleration_m_s2 >>
          comma >> measured_s)) {
      continue;  // the comment and the heading
    }
    const Limits limits{Vec3::Constant(speed_m_s * 1000.0),
                        Vec3::Constant(acceleration_m_s2 * 1000.0)};
    const double ours_s = static_cast<double>(EstimateTicks(job, job.front(), limits,
                                                            rate_hz, Profile::kMix)) /
                          rate_hz;
    // The table is rounded to 1 s.
    EXPECT_NEAR(ours_s, measured_s, 1.0) << line;
    square_s2 += (ours_s - measured_s) * (ours_s - measured_s);
    ++rows;
  }
  EXPECT_EQ(rows, 53);
  // Rounding to 1 s alone gives 0.29 s rms.
  EXPECT_LT(std::sqrt(square_s2 / rows), 0.35);
  RecordProperty("rms_s", std::to_string(std::sqrt(square_s2 / rows)));
}

}  // namespace
}  // namespace intaglio::motion
