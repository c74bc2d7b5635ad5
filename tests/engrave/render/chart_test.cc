#include "engrave/render/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::render {
namespace {

TEST(Chart, MarksAreRoundAndCoverTheRange) {
  for (const auto& [min, max] : {std::pair(0.0, 1.0),
                                 {-3.959, 6.449},
                                 {0.0, 0.0},
                                 {1e-9, 1.3e-9},
                                 {250.0, 251.0},
                                 {-7e6, 2e5}}) {
    for (const int count : {3, 8, 12}) {
      const auto marks = RoundNumbers(min, max, count);
      ASSERT_GE(marks.size(), 2u);
      EXPECT_LE(marks.size(), static_cast<std::size_t>(count) + 1) << min << " " << max;
      EXPECT_LE(marks.front(), min);
      EXPECT_GE(marks.back(), max);
      const double step = marks[1] - marks[0];
      const double digit = step / std::pow(10, std::floor(std::log10(step * 1.0001)));
      EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 ||
                  std::abs(digit - 5) < 1e-6)
          << digit;
    }
  }
}

/// Pixels that differ from the corner, which is ground.
int Drawn(const Canvas& canvas) {
  int count = 0;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const Color &a = canvas.at(x, y), &b = canvas.at(0, 0);
      if (std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) > 0.05F)
        ++count;
    }
  }
  return count;
}

TEST(Chart, ACurveLiesWhereItsPointsAre) {
  const ChartOptions options{"t", "x", "y", 800, 500};
  const Canvas empty = DrawChart({}, options);
  // From one end of the axes to the other: a diagonal of the frame.
  const Canvas line = DrawChart({{"", {{0, 0}, {1, 1}}}}, options);
  const int length_px = static_cast<int>(std::hypot(800 - 140, 500 - 130));
  EXPECT_GT(Drawn(line), Drawn(empty) + length_px);
  // The middle of the frame, which is between the marks of both axes.
  const Color& middle = line.at(110 + (800 - 140) / 4 + 10, 430 - (500 - 130) / 4 - 6);
  EXPECT_GT(middle.r + middle.g + middle.b, 0.3F);
}

TEST(Chart, WhatIsNoNumberIsLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(DrawChart({{"", {{0, 0}, {nan, 1}, {1, nan}, {2, 1}}}}, {}));
  EXPECT_THROW(DrawChart({}, {"", "", "", 100, 500}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::render
