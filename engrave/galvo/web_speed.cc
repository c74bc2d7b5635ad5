#include "engrave/galvo/web_speed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engrave/core/try.h"

// The smallest ratio of numerators s_j - s_i + L - (w_i + w_j) / 2 and denominators
// C_{j+1} - C_i, C the sums of the times, by Dinkelbach's method (1967, On Nonlinear
// Fractional Programming): of the pair with the smallest numerator - v denominator the
// ratio is the next v, which falls to the smallest. That pair is found in one pass, for
// the difference is a term of j minus one of i <= j.

namespace intaglio::galvo {
namespace {

constexpr int kMaxRounds = 1000;

Status CheckMarks(std::span<const TimedMark> marks, double field_mm) {
  const auto fail = [](std::size_t i, const char* what, double value,
                       const std::string& remedy) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("mark {}: {} is {:.6g}; {}", i + 1, what, value, remedy),
                fmt::format("{:.6g}", value));
  };
  if (marks.empty())
    return Fail(ErrorCode::kInvalidValue, "there is no mark; give one or more");
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const TimedMark& mark = marks[i];
    if (!std::isfinite(mark.along_mm))
      return fail(i, "its place along the web, mm,", mark.along_mm, "give a number");
    if (!(mark.extent_mm >= 0 && mark.extent_mm < field_mm))
      return fail(
          i, "its extent along the web, mm,", mark.extent_mm,
          fmt::format("give 0 or more and less than the field of {:.6g} mm", field_mm));
    if (!(mark.time_s > 0) || !std::isfinite(mark.time_s))
      return fail(i, "its time, s,", mark.time_s, "give a time above 0");
  }
  return {};
}

struct Ratio {
  double way_mm, time_s;
};

/// Finds the pair i <= j with the smallest way - v time.
Ratio SmallestAt(std::span<const TimedMark> marks, double field_mm, double speed_mm_s) {
  double smallest = std::numeric_limits<double>::infinity(), sum_s = 0;
  double first = -smallest, first_way_mm = 0, first_s = 0;
  Ratio ratio{};
  for (const TimedMark& mark : marks) {
    const double begin_mm = mark.along_mm + mark.extent_mm / 2;
    if (begin_mm - speed_mm_s * sum_s > first) {
      first = begin_mm - speed_mm_s * sum_s;
      first_way_mm = begin_mm, first_s = sum_s;
    }
    sum_s += mark.time_s;
    const double end_mm = mark.along_mm - mark.extent_mm / 2 + field_mm;
    const double value = end_mm - speed_mm_s * sum_s - first;
    if (value < smallest) {
      smallest = value;
      ratio = {end_mm - first_way_mm, sum_s - first_s};
    }
  }
  return ratio;
}

}  // namespace

Result<double> MaxSpeed(std::span<const TimedMark> marks, double field_mm) {
  INTAGLIO_TRY(CheckMarks(marks, field_mm));
  double speed_mm_s = std::numeric_limits<double>::infinity();
  for (const TimedMark& mark : marks)
    speed_mm_s = std::min(speed_mm_s, (field_mm - mark.extent_mm) / mark.time_s);
  for (int round = 0; round < kMaxRounds; ++round) {
    const Ratio ratio = SmallestAt(marks, field_mm, speed_mm_s);
    const double next_mm_s = ratio.way_mm / ratio.time_s;
    if (!(next_mm_s < speed_mm_s)) break;
    speed_mm_s = next_mm_s;
    if (speed_mm_s <= 0) {
      return Fail(
          ErrorCode::kInvalidValue,
          "a mark has left the field before an earlier one of this order arrives; "
          "mark in the order of arrival");
    }
  }
  return speed_mm_s;
}

Result<double> FrameSpeed(std::span<const TimedMark> marks, double field_mm) {
  INTAGLIO_TRY(CheckMarks(marks, field_mm));
  const auto first = std::min_element(
      marks.begin(), marks.end(),
      [](const TimedMark& a, const TimedMark& b) { return a.along_mm < b.along_mm; });
  std::map<double, double> time_s;  // of a frame, by its number
  double largest_s = 0;
  for (const TimedMark& mark : marks) {
    double& sum = time_s[std::floor((mark.along_mm - first->along_mm) / (field_mm / 2))];
    largest_s = std::max(largest_s, sum += mark.time_s);
  }
  return field_mm / 2 / largest_s;
}

std::vector<std::size_t> MissedMarks(std::span<const TimedMark> marks, double field_mm,
                                     double speed_mm_s) {
  std::vector<std::size_t> missed;
  double now_s = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const TimedMark& mark = marks[i];
    const double half_mm = (field_mm - mark.extent_mm) / 2;
    const double done_s =
        std::max(now_s, (mark.along_mm - half_mm) / speed_mm_s) + mark.time_s;
    // At the largest speed the last is just made; rounding must not make it missed.
    const double left_s = (mark.along_mm + half_mm) / speed_mm_s;
    if (done_s > left_s + 1e-12 * (1 + std::abs(left_s))) {
      missed.push_back(i);
    } else {
      now_s = done_s;
    }
  }
  return missed;
}

}  // namespace intaglio::galvo
