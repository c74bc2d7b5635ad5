#pragma once

// The measured tables of the published machine (Trochimczuk 2008 ch. 6.3, annex F) and
// its model: a stop at each point, profile mix, each step in whole ticks.

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"
#include "tests/engrave/motion/stop_and_go_ticks.h"

namespace intaglio::motion {

/// A row of tests/data/published/els03_timings.csv.
struct MeasuredTime {
  double rate_hz = 0, speed_mm_s = 0, acceleration_mm_s2 = 0;
  double time_s = 0;  ///< as printed, whole seconds
};

/// A row of tests/data/published/els03_sort_angle.csv, at 100 Hz, 80 mm/s and 7 m/s^2.
struct MeasuredAngle {
  double angle_deg = 0, time_s = 0;
};

namespace published_internal {

/// The rows of numbers of a table; other lines (comment, heading) are skipped.
inline std::vector<std::vector<double>> NumbersOf(const std::string& file_name) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/tests/data/published/" + file_name);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (std::string field; std::getline(fields, field, ',');) {
      std::istringstream text(field);
      if (double number; text >> number) row.push_back(number);
    }
    if (row.size() >= 3 && line.find('#') == std::string::npos) rows.push_back(row);
  }
  return rows;
}

}  // namespace published_internal

inline std::vector<MeasuredTime> MeasuredTimes() {
  std::vector<MeasuredTime> times;
  for (const auto& row : published_internal::NumbersOf("els03_timings.csv")) {
    times.push_back({row.at(0), row.at(1) * 1000, row.at(2) * 1000, row.at(3)});
  }
  return times;
}

inline std::vector<MeasuredAngle> MeasuredAngles() {
  std::vector<MeasuredAngle> angles;
  for (const auto& row : published_internal::NumbersOf("els03_sort_angle.csv")) {
    angles.push_back({row.at(0), row.at(1)});
  }
  return angles;
}

inline Limits LimitsOf(const MeasuredTime& row) {
  return {.max_speed_mm_s = Vec3::Constant(row.speed_mm_s),
          .max_acceleration_mm_s2 = Vec3::Constant(row.acceleration_mm_s2)};
}

/// The machining time of the model, s.
inline double ModelSeconds(const PointList& path_mm, const Limits& limits,
                           double rate_hz) {
  return static_cast<double>(
             StopAndGoTicks(path_mm, path_mm.front(), limits, rate_hz, Profile::kMix)) /
         rate_hz;
}

}  // namespace intaglio::motion
